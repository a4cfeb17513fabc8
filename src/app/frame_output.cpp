#include "app/frame_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/option_values.hpp"
#include "app/output_file.hpp"
#include "app/transfer_function_option.hpp"
#include "app/views.hpp"
#include "ringsplat/app/image_io.hpp"
#include "ringsplat/base/log.hpp"

namespace ringsplat::app {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// All of it but the time, which differs from run to run.
json to_json(const MeasuredError& m) {
  return {{"truth", to_string(m.truth)}, {"pixels", m.error.pixels},     {"seed", m.seed},
          {"rmse", m.error.rmse},        {"rmse_low", m.error.rmse_low}, {"rmse_high", m.error.rmse_high},
          {"largest", m.error.largest},  {"mean", m.error.mean},         {"unit", "1/255"}};
}

/// The settings that decide the picture, and the volume: the same bytes for any ranks that rendered it.
std::string picture_settings(const FrameSpec& spec, const VolumeOptions& volume, const MeasuredError* error) {
  json j = json::parse(to_json_text(spec));
  if (error != nullptr) j["error"] = to_json(*error);
  j["volume"] = fs::path(volume.path).filename().string();
  return j.dump();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

json to_json(const SliceMemory& memory) {
  std::string axes;
  for (const Axis axis : all_axes)
    if (memory.kept_axes[std::size_t(axis)]) axes += name(axis);
  return {{"kept_axes", axes}, {"predicted_slice_bytes", memory.predicted}};
}

}  // namespace

FrameOutput::FrameOutput(const RenderOptions& options, const Layout& layout, const ValueRange& range,
                         SliceMemory memory, std::vector<fs::path> files, Progress& progress)
    : options_(options),
      layout_(layout),
      range_(range),
      memory_(std::move(memory)),
      files_(std::move(files)),
      progress_(progress) {}

void FrameOutput::take(FrameResult&& result) {
  if (options_.error.truth) {
    kept_.push_back(std::move(result));
    progress_.at(double(kept_.size()));
  } else {
    write(result, nullptr);
    progress_.at(double(seconds_.size()));
  }
}

void FrameOutput::measure_kept() {
  const auto source = open_volume(options_.volume.path, options_.volume.raw);
  truth::Scene scene = make_scene(read_whole(*source));
  for (const FrameResult& result : kept_) {
    set_frame(scene, result.spec);
    const MeasuredError error = measure(result.image, scene, options_.error);
    write(result, &error);
    progress_.print(to_text(error));
  }
  kept_.clear();
}

void FrameOutput::write(const FrameResult& result, const MeasuredError* error) {
  const auto index = static_cast<std::size_t>(result.spec.frame);
  const fs::path& file = files_.at(index);
  write_image(result.image, file, options_.background, picture_settings(result.spec, options_.volume, error));
  const NodeStats sum = result.stats.total();
  if (sum.splats_drawn == 0 && empty_frames_++ == 0) {
    progress_.clear();
    log_warning("{}: {}", file.string(), why_nothing_is_visible(result.spec.transfer_function, range_));
  }
  progress_.print(fmt::format("{}  {:.4f} s  {} visible voxels  {} splats", file.string(),
                              result.stats.seconds, sum.visible_voxels, sum.splats_sent));
  seconds_.push_back(result.stats.seconds);
  if (!options_.stats.empty()) {
    json j = json::parse(to_json_text(result.stats, result.spec, layout_));
    j["file"] = file.string();
    j["volume"] = options_.volume.path;
    j["memory"] = to_json(memory_);
    if (error != nullptr) {
      j["error"] = to_json(*error);
      j["error"]["seconds"] = error->seconds;
    }
    stats_.push_back(j.dump());
  }
}

std::string FrameOutput::stats_text() const {
  const bool lines = fs::path(options_.stats).extension() == ".jsonl";
  return lines ? fmt::format("{}\n", joined(stats_, "\n")) : fmt::format("[\n{}\n]\n", joined(stats_, ",\n"));
}

void FrameOutput::finish() {
  if (!kept_.empty()) measure_kept();
  if (!options_.stats.empty()) write_text(options_.stats, stats_text());
  if (empty_frames_ > 1) log_warning("{} of {} frames are empty", empty_frames_, seconds_.size());
  if (files_.size() > 1)
    progress_.print(fmt::format("{} frames, median {:.4f} s", seconds_.size(), median(seconds_)));
}

std::vector<Camera> views_of(const RenderOptions& o) {
  if (o.orbit > 0) return orbit(o.frame.camera, o.orbit);
  return o.path.empty() ? std::vector{o.frame.camera} : read_path(o.path, o.frame.camera);
}

std::vector<fs::path> output_files(const RenderOptions& options, std::size_t frames) {
  if (options.orbit == 0 && options.path.empty()) return {options.output};
  std::vector<fs::path> files;
  for (std::size_t k = 0; k < frames; ++k) files.push_back(numbered(options.output, k));
  return files;
}

}  // namespace ringsplat::app

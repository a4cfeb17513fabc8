#include "app/frame_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/json_text.hpp"
#include "app/option_values.hpp"
#include "app/text_output.hpp"
#include "app/transfer_function_option.hpp"
#include "app/views.hpp"
#include "base/log.hpp"
#include "base/output_file.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "images/image_io.hpp"
#include "record/stats_table.hpp"

namespace ringsplat::app {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// All but the time, which differs from run to run.
json to_json(const MeasuredError& m) {
  return {{"truth", to_string(m.truth)},    {"pixels", m.error.pixels},
          {"outside", m.error.outside},     {"seed", m.seed},
          {"rmse", m.error.rmse},           {"rmse_low", m.error.rmse_low},
          {"rmse_high", m.error.rmse_high}, {"largest", m.error.largest},
          {"mean", m.error.mean},           {"unit", "1/255"}};
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

std::string picture_settings(const FrameSpec& spec, const std::string& volume, bool annotated,
                             const MeasuredError* error) {
  json j = json::parse(to_json_text(spec));
  if (error != nullptr) j["error"] = to_json(*error);
  if (annotated) j["annotated"] = true;
  j["volume"] = fs::path(volume).filename().string();
  return plain_json_text(std::move(j));
}

namespace {

/// The mean opacity of the picture's pixels.
double mean_opacity(const Image& image) {
  double sum = 0;
  for (std::size_t k = 3; k < image.rgba.size(); k += 4) sum += double(image.rgba[k]);
  return image.rgba.empty() ? 0 : 4 * sum / double(image.rgba.size());
}

/// A useful picture has a tenth of all light stopped in the mean, and often more; a thousandth of that is
/// nearly nothing.
constexpr double least_mean_opacity = 0.1 / 1000;

}  // namespace

std::string why_empty(const FrameResult& result, const ValueRange& range) {
  const NodeStats sum = result.stats.total();
  if (sum.splats_drawn > 0) return {};
  return why_nothing_is_visible(result.spec.shown.transfer_function, range,
                                sum.visible_voxels + sum.voxels_outside);
}

std::string why_nearly_empty(const FrameResult& result) {
  const double opacity = mean_opacity(result.image);
  if (result.stats.total().splats_drawn == 0 || opacity >= least_mean_opacity) return {};
  return why_hardly_anything_is_visible(opacity, result.spec);
}

FrameOutput::FrameOutput(const RenderOptions& options, const Layout& layout, const ValueRange& range,
                         SliceMemory memory, Progress& progress)
    : options_(options),
      layout_(layout),
      volume_(options.volume.path),
      range_(range),
      memory_(std::move(memory)),
      progress_(progress),
      writer_([this](FinishedFrame&& frame) {
        write(frame, nullptr);
        progress_.at(double(seconds_.size()));
      }) {}

std::size_t FrameOutput::most_held(const RenderOptions& options, std::size_t frames) {
  const auto in_flight = std::size_t(options.run.protocol.frames_in_flight);
  if (options.error.truth) return std::max(in_flight, frames);
  return in_flight + std::min(frames, FrameWriter::room + 1);
}

void FrameOutput::take(FrameResult&& result, std::size_t view, int factor) {
  fs::path file = output_file(options_, view);
  if (options_.progressive && factor > 1)
    file.replace_filename(fmt::format("{}-u{}{}", file.stem().string(), factor, file.extension().string()));
  if (options_.error.truth) {
    kept_.push_back({std::move(result), std::move(file), volume_, range_});
    progress_.at(double(kept_.size()));
  } else {
    writer_.put({std::move(result), std::move(file), volume_, range_});
  }
}

void FrameOutput::show(const std::string& volume, const ValueRange& range) {
  volume_ = volume;
  range_ = range;
}

const MeasuredError& FrameOutput::error_of(KeptFrame& kept) {
  if (kept.error) return *kept.error;
  if (!truth_) truth_ = make_scene(read_whole(*open_volume(options_.volume)));
  FrameSpec asked = kept.frame.result.spec;
  asked.how = options_.frame.how;  // an error budget may have chosen a cheaper one
  set_frame(*truth_, asked);
  return kept.error.emplace(measure(kept.frame.result.image, *truth_, options_.error));
}

std::vector<Judged> FrameOutput::judge() {
  std::vector<Judged> judged;
  for (KeptFrame& kept : kept_) {
    const FrameSpec& spec = kept.frame.result.spec;
    if (kept.error || (options_.progressive && spec.shown.reduction.factor > 1)) continue;
    judged.push_back({spec, kept.frame.file.string(), error_of(kept).error.rmse});
  }
  truth_.reset();
  return judged;
}

void FrameOutput::replace(FrameResult&& result) {
  for (KeptFrame& kept : kept_) {
    if (kept.frame.result.spec.frame != result.spec.frame) continue;
    kept.frame.result = std::move(result);
    kept.error.reset();
    return;
  }
}

void FrameOutput::warn(const std::string& label, const std::string& why, int& frames) {
  if (why.empty() || frames++ > 0) return;
  progress_.clear();
  log_warning("{}: {}", label, why);
}

void FrameOutput::write(const FinishedFrame& frame, const MeasuredError* error) {
  const auto& [result, file, volume, range] = frame;
  const bool drawn = !options_.run.engine.simulation.count_only, written = !options_.output.empty();
  const std::string label =
      written && !names_film(options_.output) ? file.string() : fmt::format("frame {}", result.spec.frame);
  const Overlay overlay = written && annotation_ ? annotation_->overlay(result.spec, range) : Overlay{};
  if (written && names_film(options_.output))
    film_.add(result.image, options_.background, overlay);
  else if (written)
    write_image(result.image, file, options_.background,
                picture_settings(result.spec, volume, options_.annotate, error), overlay);
  const NodeStats sum = result.stats.total();
  warn(label, drawn ? why_empty(result, range) : std::string(), empty_frames_);
  warn(label, drawn ? why_nearly_empty(result) : std::string(), nearly_empty_frames_);
  const std::string after =
      seconds_.empty() ? "" : fmt::format(", {:.4f} s after the one before", result.stats.period);
  const std::string shown =
      options_.frames
          ? fmt::format("  {}: {:g} to {:g}", fs::path(volume).filename().string(), range.low, range.high)
          : "";
  progress_.print(fmt::format("{}  {:.4f} s{}  {} visible voxels  {} {}{}", label, result.stats.seconds,
                              after, sum.visible_voxels, sum.splats_sent, items_of(result.spec.how), shown));
  seconds_.push_back(result.stats.seconds);
  period_sum_ += result.stats.period;
  if (!options_.stats.empty())
    records_.push_back({result.spec, result.stats, result.axis, written ? file.string() : std::string(),
                        error == nullptr ? std::nullopt : std::optional(*error), volume});
}

std::string FrameOutput::json_text(const FrameRecord& record) const {
  json j = json::parse(to_json_text(record.stats, layout_, to_json_text(record.spec), name(record.axis)));
  if (!record.picture.empty()) j["file"] = record.picture;
  j["volume"] = record.volume;
  j["memory"] = to_json(memory_);
  if (record.error) {
    j["error"] = to_json(*record.error);
    j["error"]["seconds"] = record.error->seconds;
  }
  if (const auto step = refinements_.find(record.spec.frame); step != refinements_.end()) {
    const auto& [seconds, rmse, largest] = step->second;
    j["refinement"] = {{"seconds", seconds}, {"rmse", rmse}, {"largest", largest}, {"unit", "1/255"}};
  }
  return plain_json_text(std::move(j));
}

std::string FrameOutput::stats_text() const {
  if (options_.stats_as_table) {
    StatsTable table(layout_);
    for (const FrameRecord& record : records_) table.add(record.stats);
    return table.text(items_of(records_.empty() ? options_.frame.how : records_.front().spec.how));
  }
  std::vector<std::string> texts;
  texts.reserve(records_.size());
  for (const FrameRecord& record : records_) texts.push_back(json_text(record));
  const bool lines = fs::path(options_.stats).extension() == ".jsonl";
  return lines ? fmt::format("{}\n", joined(texts, "\n")) : fmt::format("[\n{}\n]\n", joined(texts, ",\n"));
}

void FrameOutput::finish() {
  writer_.finish();
  for (KeptFrame& kept : kept_) {
    const MeasuredError& error = error_of(kept);
    write(kept.frame, &error);
    progress_.print(to_text(error));
  }
  truth_.reset();
  if (!options_.stats.empty()) write_text_output(options_.stats, stats_text());
  if (empty_frames_ > 1) log_warning("{} of {} frames are empty", empty_frames_, seconds_.size());
  if (nearly_empty_frames_ > 1)
    log_warning("{} of {} frames are nearly empty", nearly_empty_frames_, seconds_.size());
  if (seconds_.size() > 1) progress_.print(summary());
}

void FrameOutput::make_film() {
  if (!names_film(options_.output)) return;
  progress_.begin("making the film", 0);
  film_.write(options_.output);
  progress_.end();
  progress_.print(options_.output);
}

/// Gives a rate, too, since frames overlap; but not where refinements may be dropped, whose time belongs to
/// no picture.
std::string FrameOutput::summary() const {
  std::string text =
      fmt::format("{} frames, median {:.4f} s from start to end", seconds_.size(), median(seconds_));
  if (!(options_.progressive && options_.path == "-"))
    text += fmt::format(", one every {:.4f} s", period_sum_ / double(seconds_.size()));
  return text;
}

fs::path output_file(const RenderOptions& options, std::size_t view) {
  const bool several = options.orbit > 0 || !options.path.empty() || options.frames;
  return several && !names_film(options.output) ? numbered(options.output, view) : fs::path(options.output);
}

namespace {

std::vector<Camera> cameras_of(const std::vector<ViewAngles>& views, const Camera& start) {
  std::vector<Camera> cameras;
  for (const ViewAngles& view : views) {
    Camera camera = start;
    camera.azimuth = view.azimuth.value_or(camera.azimuth);
    camera.elevation = view.elevation.value_or(camera.elevation);
    camera.roll = view.roll.value_or(camera.roll);
    camera.zoom = view.zoom.value_or(camera.zoom);
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace

std::vector<Camera> views_of(const RenderOptions& o) {
  if (o.orbit > 0) return orbit(o.frame.shown.camera, o.orbit);
  if (!o.views.empty()) return cameras_of(o.views, o.frame.shown.camera);
  if (o.path == "-") return {};
  return o.path.empty() ? std::vector{o.frame.shown.camera} : read_path(o.path, o.frame.shown.camera);
}

}  // namespace ringsplat::app

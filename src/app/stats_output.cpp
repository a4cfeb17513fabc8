#include "app/stats_output.hpp"

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "frame/frame_spec_bytes.hpp"
#include "options/method_options.hpp"
#include "options/option_values.hpp"
#include "program/text_output.hpp"

namespace ringsplat::app {

using nlohmann::json;

json to_json(const MeasuredError& m) {
  return {{"truth", to_string(m.truth)},    {"pixels", m.error.pixels},
          {"outside", m.error.outside},     {"seed", m.seed},
          {"rmse", m.error.rmse},           {"rmse_low", m.error.rmse_low},
          {"rmse_high", m.error.rmse_high}, {"largest", m.error.largest},
          {"mean", m.error.mean},           {"unit", "1/255"}};
}

namespace {

json to_json(const SliceMemory& memory) {
  std::string axes;
  for (const Axis axis : all_axes)
    if (memory.kept_axes[std::size_t(axis)]) axes += name(axis);
  return {{"kept_axes", axes}, {"predicted_slice_bytes", memory.predicted}};
}

}  // namespace

StatsOutput::StatsOutput(const RenderOptions& options, const Layout& layout, SliceMemory memory)
    : file_(options.stats),
      lines_(std::filesystem::path(file_).extension() == ".jsonl"),
      layout_(layout),
      memory_(std::move(memory)),
      items_(items_of(options.frame.how)) {
  if (options.stats_as_table) table_.emplace(layout);
}

void StatsOutput::add(const FrameResult& frame, const std::string& picture, const MeasuredError* error,
                      const std::string& volume) {
  if (table_) {
    table_->add(frame.stats);
    items_ = items_of(frame.spec.how);
  }
  if (table_ || file_.empty()) return;
  json j = json::parse(to_json_text(frame.stats, layout_, to_json_text(frame.spec), name(frame.axis)));
  if (!picture.empty()) j["file"] = picture;
  j["volume"] = volume;
  j["memory"] = to_json(memory_);
  if (error != nullptr) {
    j["error"] = to_json(*error);
    j["error"]["seconds"] = error->seconds;
  }
  waiting_.emplace_back(frame.spec.frame, std::move(j));
}

void StatsOutput::write(const RefinementSteps& steps) {
  for (auto& [frame, j] : waiting_) {
    if (const auto step = steps.find(frame); step != steps.end()) {
      const auto& [seconds, rmse, largest] = step->second;
      j["refinement"] = {{"seconds", seconds}, {"rmse", rmse}, {"largest", largest}, {"unit", "1/255"}};
    }
    if (std::exchange(begun_, true))
      put(lines_ ? "\n" : ",\n");
    else if (!lines_)
      put("[\n");
    put(plain_json_text(std::move(j)));
  }
  waiting_.clear();
}

void StatsOutput::finish() {
  if (file_.empty()) return;
  if (table_) return write_text_output(file_, table_->text(items_));
  write({});
  put(lines_ ? "\n" : begun_ ? "\n]\n" : "[\n\n]\n");
  if (output_)
    output_->commit();
  else
    flush_stdout();
}

void StatsOutput::put(const std::string& text) {
  if (is_stdout(file_)) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    return;
  }
  if (!output_) output_ = std::make_unique<OutputFile>(file_);
  output_->write(text);
}

}  // namespace ringsplat::app

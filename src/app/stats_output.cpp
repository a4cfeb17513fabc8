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

void StatsOutput::add(FrameRecord&& record) {
  if (table_) {
    table_->add(record.stats);
    items_ = items_of(record.spec.how);
  } else if (!file_.empty()) {
    waiting_.push_back(std::move(record));
  }
}

void StatsOutput::write(const RefinementSteps& steps) {
  for (const FrameRecord& record : waiting_) {
    if (std::exchange(begun_, true))
      put(lines_ ? "\n" : ",\n");
    else if (!lines_)
      put("[\n");
    put(json_text(record, steps));
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

std::string StatsOutput::json_text(const FrameRecord& record, const RefinementSteps& steps) const {
  json j = json::parse(to_json_text(record.stats, layout_, to_json_text(record.spec), name(record.axis)));
  if (!record.picture.empty()) j["file"] = record.picture;
  j["volume"] = record.volume;
  j["memory"] = to_json(memory_);
  if (record.error) {
    j["error"] = to_json(*record.error);
    j["error"]["seconds"] = record.error->seconds;
  }
  if (const auto step = steps.find(record.spec.frame); step != steps.end()) {
    const auto& [seconds, rmse, largest] = step->second;
    j["refinement"] = {{"seconds", seconds}, {"rmse", rmse}, {"largest", largest}, {"unit", "1/255"}};
  }
  return plain_json_text(std::move(j));
}

}  // namespace ringsplat::app

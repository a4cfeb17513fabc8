#pragma once
// Only frame_output.cpp includes it.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/render_job.hpp"
#include "base/output_file.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "net/message.hpp"
#include "program/text_output.hpp"

namespace ringsplat::app {

using nlohmann::json;

/// All but the time, which differs from run to run.
inline json to_json(const MeasuredError& m) {
  json all{{"truth", name(m.truth)},         {"pixels", m.error.pixels},
           {"outside", m.error.outside},     {"seed", m.seed},
           {"rmse", m.error.rmse},           {"rmse_low", m.error.rmse_low},
           {"rmse_high", m.error.rmse_high}, {"largest", m.error.largest},
           {"mean", m.error.mean},           {"unit", "1/255"}};
  if (m.certificate) {
    const Certificate& c = *m.certificate;
    all.update(
        {{"largest_low", c.least}, {"widest", c.widest}, {"proved", c.proved}, {"proved_within", c.limits}});
    if (c.replaced) all["replaced"] = *c.replaced;
  }
  return all;
}

/// What slices are kept, and foreseen to take.
inline json memory_of(const Job& job) {
  std::string axes;
  for (const Axis axis : all_axes)
    if (job.load.kept_axes[std::size_t(axis)]) axes += name(axis);
  return {{"kept_axes", axes}, {"predicted_slice_bytes", job.slice_bytes}};
}

inline double busy_seconds(const NodeStats& s) {
  return s.computing + s.drawing + s.compositing + s.delivering;
}
inline double megabytes(std::uint64_t bytes) { return double(bytes) / 1e6; }

/// A frame's settings. Of channels that were added each has its transfer function.
inline json settings_of(const FrameSpec& spec, const std::vector<DrawnChannel>& channels) {
  json all = json::parse(to_json_text(spec));
  for (const DrawnChannel& channel : channels) {
    FrameSpec alone = spec;
    alone.shown.transfer_function = channel.function;
    const json function = json::parse(to_json_text(alone))["transfer_function"];
    all["channels"].push_back(
        {{"channel", channel.choice}, {"name", channel.name}, {"transfer_function", function}});
  }
  if (!channels.empty()) all.erase("transfer_function");
  return all;
}

/// The file of --stats, to which each frame goes as soon as all is known of it.
class StatsOutput {
 public:
  /// No file where the options name none. What is passed by reference must outlive it.
  explicit StatsOutput(const Job& job)
      : job_(job),
        file_(job.options.stats),
        lines_(std::filesystem::path(file_).extension() == ".jsonl"),
        items_(items_of(job.options.frame.how)),
        gps_(std::size_t(job.layout.gps)),
        renderers_(std::size_t(job.layout.renderers)) {}

  /// `picture`: the frame's file; empty when none was written. `error` may be null. Throws RunError when the
  /// file cannot be written.
  void add(const FrameResult& frame, const std::string& picture, const MeasuredError* error,
           const std::string& volume) {
    if (job_.options.stats_as_table) {
      ++frames_;
      for (std::size_t g = 0; g < frame.stats.gps.size(); ++g) gps_.at(g) += frame.stats.gps[g];
      for (std::size_t r = 0; r < frame.stats.renderers.size(); ++r)
        renderers_.at(r) += frame.stats.renderers[r];
      items_ = items_of(frame.spec.how);
    }
    if (job_.options.stats_as_table || file_.empty()) return;
    json j = json::parse(to_json_text(frame.stats, job_.layout, settings_of(frame.spec, job_.channels).dump(),
                                      name(frame.axis)));
    if (!picture.empty()) j["file"] = picture;
    j["volume"] = volume;
    j["memory"] = memory_of(job_);
    if (error != nullptr) {
      j["error"] = to_json(*error);
      j["error"]["seconds"] = error->seconds;
    }
    if (std::exchange(begun_, true))
      put(lines_ ? "\n" : ",\n");
    else if (!lines_)
      put("[\n");
    put(plain_json_text(std::move(j)));
  }

  void finish() {
    if (file_.empty()) return;
    if (job_.options.stats_as_table) return write_text_output(file_, table());
    put(lines_ ? "\n" : begun_ ? "\n]\n" : "[\n\n]\n");
    if (output_)
      output_->commit();
    else
      flush_stdout();
  }

 private:
  void put(const std::string& text) {
    if (is_stdout(file_)) {
      std::fwrite(text.data(), 1, text.size(), stdout);
      return;
    }
    if (!output_) output_ = std::make_unique<OutputFile>(file_);
    output_->write(text);
  }

  /// What each rank did in all frames, for people.
  std::string table() const {
    std::string text = fmt::format(
        "{} frame{}, sums\n{:>6}  {:<24}{:>10}{:>11}{:>7}{:>11}{:>13}{:>11}{:>15}{:>15}\n", frames_,
        frames_ == 1 ? "" : "s", "rank", "nodes", "busy s", "waiting s", "busy", "sent MB", "received MB",
        "memory MB", fmt::format("{} sent", items_), fmt::format("{} drawn", items_));
    for (int rank = 0; rank < job_.layout.working_ranks(); ++rank) {
      NodeStats sum;
      std::string nodes;
      double there = 0;  // a rank's nodes take turns: while one works the other waits
      for (const NodeId node : job_.layout.nodes_on(rank)) {
        if (node == frame_buffer_id) continue;
        const NodeStats& one = (node.role == Role::gp ? gps_ : renderers_).at(std::size_t(node.index));
        sum += one;
        there = std::max(there, busy_seconds(one) + one.waiting_for_token + one.sending + one.idle);
        nodes += (nodes.empty() ? "" : ", ") + to_string(node);
      }
      const double busy = busy_seconds(sum), waiting = std::max(0.0, there - busy);
      text += fmt::format(
          "{:>6}  {:<24}{:>10.3f}{:>11.3f}{:>5.0f} %{:>11.2f}{:>13.2f}{:>11.0f}{:>15}{:>15}\n", rank, nodes,
          busy, waiting, busy > 0 ? 100 * busy / (busy + waiting) : 0.0,
          megabytes(sum.payload_bytes_sent + sum.tile_bytes), megabytes(sum.payload_bytes_received),
          megabytes(sum.peak_memory), sum.splats_sent, sum.splats_drawn);
    }
    if (job_.layout.idle > 0) text += fmt::format("{:>6}  idle\n", fmt::format("+{}", job_.layout.idle));
    return text;
  }

  const Job& job_;
  const std::string& file_;
  const bool lines_;   ///< not an array
  const char* items_;  ///< what payloads hold
  int frames_ = 0;
  std::vector<NodeStats> gps_, renderers_;  ///< sums
  std::unique_ptr<OutputFile> output_;      ///< null before the first frame, or for stdout
  bool begun_ = false;
};

}  // namespace ringsplat::app

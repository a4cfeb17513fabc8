#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/clock.hpp"
#include "record/stats.hpp"
#include "record/trace.hpp"

namespace ringsplat {

/// What a node was doing for a while, and for which frame and step.
struct Turn {
  std::optional<Activity> activity;  ///< none: idle
  std::int64_t frame = 0;
  std::int32_t step = -1;
  StageSeconds stages = {};  ///< part of a slice's seconds
  double compositing = 0;    ///< the last part of a payload's seconds
};

/// Books where a node's time goes: seconds for its statistics, and spans for its timeline if there is one.
class NodeBook {
 public:
  /// `trace` may be null: no timeline. It must outlive the book.
  NodeBook(NodeId node, Trace* trace)
      : trace_(trace != nullptr ? trace->of(node) : nullptr), last_time_(now_seconds()) {}

  /// Adds the seconds since the last call to `stats`, unless it is null.
  void turn(const Turn& turn, NodeStats* stats) {
    const double now = now_seconds();
    const double begin = std::exchange(last_time_, now);
    if (stats == nullptr) return;
    const double compositing = std::min(turn.compositing, now - begin);
    stats->*(turn.activity ? node_seconds[std::size_t(*turn.activity)] : &NodeStats::idle) +=
        now - begin - compositing;
    stats->compositing += compositing;
    if (trace_ != nullptr && turn.activity) add_spans(turn, begin, now);
  }

  /// Puts a moment into the timeline.
  void mark(Moment moment, std::int64_t frame, std::int32_t step, std::int32_t renderer) {
    if (trace_ != nullptr) trace_->mark(moment, frame, step, renderer, now_seconds());
  }

 private:
  void add_spans(const Turn& turn, double begin, double end) {
    const double composited = std::max(begin, end - turn.compositing);
    trace_->add(*turn.activity, turn.frame, turn.step, begin, composited, turn.stages);
    if (composited < end) trace_->add(Activity::composite, turn.frame, turn.step, composited, end);
  }

  NodeTrace* trace_;
  double last_time_;
};

}  // namespace ringsplat

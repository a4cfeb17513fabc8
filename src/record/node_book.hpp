#pragma once
#include <cstdint>
#include <optional>

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
  NodeBook(NodeId node, Trace* trace);

  /// Adds the seconds since the last call to `stats`, unless it is null.
  void turn(const Turn& turn, NodeStats* stats);
  /// Puts a moment into the timeline.
  void mark(Moment moment, std::int64_t frame, std::int32_t step, std::int32_t renderer);

 private:
  void add_spans(const Turn& turn, double begin, double end);

  NodeTrace* trace_;
  double last_time_;
};

}  // namespace ringsplat

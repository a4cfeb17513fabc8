#pragma once
#include <cstdint>
#include <optional>

#include "ringsplat/record/stats.hpp"
#include "ringsplat/record/trace.hpp"

namespace ringsplat {

/// What a node was doing for a while, and for which frame and step.
struct Turn {
  std::optional<Activity> activity;  ///< nothing: it was idle
  std::int64_t frame = 0;
  std::int32_t step = -1;
  StageSeconds stages = {};    ///< of a slice's seconds
  double compositing = 0;      ///< of a payload's seconds, the last
};

/// Books where a node's time goes: in seconds for its statistics, and as spans of its timeline when there is one.
class NodeBook {
 public:
  /// `trace` may be null: no timeline. It must outlive the book.
  NodeBook(NodeId node, Trace* trace);

  /// Books the seconds since the last call on `stats`; null: on nothing.
  void turn(const Turn& turn, NodeStats* stats);
  /// Puts a moment into the timeline.
  void mark(Moment moment, std::int64_t frame, std::int32_t step, std::int32_t renderer);

 private:
  void add_spans(const Turn& turn, double begin, double end);

  NodeTrace* trace_;
  double last_time_;
};

}  // namespace ringsplat

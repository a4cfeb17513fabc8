#include "record/node_book.hpp"

#include <algorithm>
#include <utility>

#include "base/clock.hpp"

namespace ringsplat {

NodeBook::NodeBook(NodeId node, Trace* trace)
    : trace_(trace != nullptr ? trace->of(node) : nullptr), last_time_(now_seconds()) {}

void NodeBook::turn(const Turn& turn, NodeStats* stats) {
  const double now = now_seconds();
  const double begin = std::exchange(last_time_, now);
  if (stats == nullptr) return;
  const double compositing = std::min(turn.compositing, now - begin);
  stats->*(turn.activity ? node_seconds[std::size_t(*turn.activity)] : &NodeStats::idle) +=
      now - begin - compositing;
  stats->compositing += compositing;
  if (trace_ != nullptr && turn.activity) add_spans(turn, begin, now);
}

void NodeBook::add_spans(const Turn& turn, double begin, double end) {
  const double composited = std::max(begin, end - turn.compositing);
  trace_->add(*turn.activity, turn.frame, turn.step, begin, composited, turn.stages);
  if (composited < end) trace_->add(Activity::composite, turn.frame, turn.step, composited, end);
}

void NodeBook::mark(Moment moment, std::int64_t frame, std::int32_t step, std::int32_t renderer) {
  if (trace_ != nullptr) trace_->mark(moment, frame, step, renderer, now_seconds());
}

}  // namespace ringsplat

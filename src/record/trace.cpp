#include "record/trace.hpp"

#include <algorithm>
#include <iterator>

#include "base/archive.hpp"
#include "base/clock.hpp"
#include "base/process.hpp"
#include "net/blocks.hpp"

namespace ringsplat {

void fields(ClockOffset& clock, auto& archive) {
  archive(clock.at, clock.offset, clock.uncertainty, clock.common);
}

void fields(NodeRecord& record, auto& archive) {
  archive(record.node, record.full, record.spans, record.marks);
}

namespace {

bool is_waiting(Activity a) { return a == Activity::wait_for_token || a == Activity::send; }

bool continues(const Span& last, Activity activity, std::int64_t frame, std::int32_t step, double begin) {
  return last.activity == activity && last.frame == frame && last.step == step &&
         begin - last.end <= NodeTrace::longest_gap;
}

}  // namespace

void NodeTrace::add(Activity activity, std::int64_t frame, std::int32_t step, double begin, double end) {
  auto& spans = record_.spans;
  if (!spans.empty() && is_waiting(spans.back().activity) &&
      spans.back().end - spans.back().begin < longest_gap &&
      !continues(spans.back(), activity, frame, step, begin))
    spans.pop_back();
  if (!spans.empty() && activity != Activity::frame &&
      continues(spans.back(), activity, frame, step, begin)) {
    Span& last = spans.back();
    last.end = end;
    last.busy += end - begin;
  } else if (spans.size() < capacity_) {
    spans.push_back({begin, end, end - begin, frame, step, activity});
  } else {
    record_.full = true;
  }
}

ClockOffset estimate_offset(std::span<const GatherTimes> mine, std::span<const GatherTimes> of_process_0) {
  double low = -1e300, high = 1e300;
  for (std::size_t k = 0; k < mine.size(); ++k) {
    // I entered before process 0 left, and process 0 entered before I left.
    low = std::max(low, mine[k].entered - of_process_0[k].left);
    high = std::min(high, mine[k].left - of_process_0[k].entered);
  }
  return {mine.back().left, (low + high) / 2, (high - low) / 2, false};
}

void Trace::compare_clocks(Collectives& collectives) {
  std::array<GatherTimes, 16> mine, times_of_0;
  for (auto& round : mine) {
    round.entered = now_seconds();
    collectives.all_gather(Block(1));
    round.left = now_seconds();
  }
  const std::string clock = clock_identity();
  const Block of_0 = collectives.broadcast(to_bytes(mine, clock), 0);
  std::string clock_of_0;
  read_block(of_0, "its clock's times", times_of_0, clock_of_0);
  const bool common = collectives.process() == 0 || (!clock.empty() && clock == clock_of_0);
  compared_.push_back(common ? ClockOffset{.at = mine.back().left} : estimate_offset(mine, times_of_0));
}

Trace::Gathered Trace::gather(Collectives& collectives) const {
  std::vector<NodeRecord> mine;
  for (const auto& [key, node] : nodes_) {
    NodeRecord& record = mine.emplace_back(node.record());
    for (Span& span : record.spans) {
      span.begin = in_clock_of_0(span.begin);
      span.end = in_clock_of_0(span.end);
    }
    for (Mark& mark : record.marks) mark.time = in_clock_of_0(mark.time);
  }
  const ClockOffset offset = compared_.empty() ? ClockOffset{} : compared_.back();
  const std::vector<Block> in = to_process_0(collectives, to_bytes(offset, mine));
  Gathered all;
  for (std::size_t p = 0; p < in.size(); ++p) {
    std::vector<NodeRecord> nodes;
    read_block(in[p], "what it did", all.offsets.emplace_back(), nodes);
    std::ranges::move(nodes, std::back_inserter(all.nodes));
  }
  return all;
}

}  // namespace ringsplat

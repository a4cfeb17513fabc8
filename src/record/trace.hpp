#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "net/collectives.hpp"
#include "net/message.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// What a node does during a span. `frame` is the frame buffer's: from the announcement to the last tile.
enum class Activity : std::uint8_t { slice, wait_for_token, send, draw, composite, deliver, frame };
/// An instant at a node. Each departure (pass, send) has its arrival (take) at another node.
enum class Moment : std::uint8_t { pass_token, take_token, send_payload, take_payload };

/// One activity over a while, in seconds of its process's clock.
struct Span {
  double begin = 0, end = 0;
  double busy = 0;  ///< seconds of it really spent; pieces of work are joined over short gaps
  std::int64_t frame = 0;
  std::int32_t step = 0;  ///< of the traversal; -1: not of one slice
  Activity activity = Activity::slice;
};

struct Mark {
  double time = 0;
  std::int64_t frame = 0;
  std::int32_t step = 0,
               renderer = 0;  ///< which token or payload: the token for `step` is the one passed to it
  Moment moment = Moment::pass_token;
};

/// What one node did when. Spans do not overlap (but for frames) and ascend.
struct NodeRecord {
  NodeId node;
  std::vector<Span> spans;
  std::vector<Mark> marks;
  bool full = false;  ///< some were left out
};

/// Records one node. Pieces of one activity for one slice are joined over gaps shorter than `longest_gap`,
/// and shorter waits are left out, so that a slice takes a few spans however often the node was called. Holds
/// at most `most` spans and as many marks (88 bytes for one of each).
class NodeTrace {
 public:
  static constexpr double longest_gap = 20e-6;
  static constexpr std::size_t most = std::size_t{1} << 17;

  explicit NodeTrace(NodeId node, std::size_t capacity = most) : capacity_(capacity) { record_.node = node; }
  /// All of begin … end was spent on it. Calls come in the order of time.
  void add(Activity activity, std::int64_t frame, std::int32_t step, double begin, double end);
  void mark(Moment moment, std::int64_t frame, std::int32_t step, std::int32_t renderer, double time) {
    if (record_.marks.size() < capacity_)
      record_.marks.push_back({time, frame, step, renderer, moment});
    else
      record_.full = true;
  }
  const NodeRecord& record() const { return record_; }

 private:
  std::size_t capacity_;
  NodeRecord record_;
};

/// How a process's clock relates to that of process 0.
struct ClockOffset {
  double at = 0;           ///< by this process's clock
  double offset = 0;       ///< seconds that this clock is ahead
  double uncertainty = 0;  ///< ± seconds
  bool common = true;      ///< both read the same clock, so there is nothing to estimate
};

/// When a process entered and left one round of a collective, by its own clock. No process leaves before all
/// have entered, so the times of this process and of process 0 bound the offset from both sides.
struct GatherTimes {
  double entered = 0, left = 0;
};
ClockOffset estimate_offset(std::span<const GatherTimes> mine, std::span<const GatherTimes> of_process_0);

/// The records of all nodes of a process; gathers them on process 0.
class Trace {
 public:
  /// The record of a node of this process; valid as long as the trace.
  NodeTrace* of(NodeId node) { return &nodes_.try_emplace({node.role, node.index}, node).first->second; }
  /// Compares the processes' clocks. All processes call it, before the first frame and after the last.
  void compare_clocks(Collectives& collectives);

  struct Gathered {
    std::vector<NodeRecord> nodes;     ///< by role and index, in process 0's clock
    std::vector<ClockOffset> offsets;  ///< by process, as last compared
  };
  /// Gathers everything on process 0 and returns nothing elsewhere. All processes call it. Throws RunError
  /// when a record is broken.
  Gathered gather(Collectives& collectives) const;

 private:
  /// Interpolates between two comparisons, since clocks of different machines also run at different speeds.
  double in_clock_of_0(double time) const {
    if (compared_.empty()) return time;
    const ClockOffset &first = compared_.front(), &last = compared_.back();
    if (last.at <= first.at) return time - last.offset;
    return time - first.offset - (last.offset - first.offset) * (time - first.at) / (last.at - first.at);
  }

  std::map<std::pair<Role, std::int32_t>, NodeTrace> nodes_;
  std::vector<ClockOffset> compared_;  ///< of this process, ascending
};

/// Chrome's trace-event JSON ("Trace Event Format", Google 2016), which Perfetto opens: a process for each
/// rank, a thread for each node, spans as complete events that nest, tokens and payloads as flow arrows.
///
/// Times are microseconds since the first event, exact to the nanosecond. A flow is written only when both of
/// its ends were recorded.
std::string to_chrome_trace(const Trace::Gathered& trace, const Layout& layout);

}  // namespace ringsplat

#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/byte_stream.hpp"
#include "base/clock.hpp"
#include "base/process.hpp"
#include "net/message.hpp"
#include "protocol/engine.hpp"
#include "protocol/protocol_options.hpp"
#include "record/stats.hpp"
#include "record/trace.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

class FrameSource;

/// A state machine that reacts to messages, works in bounded pieces and never blocks. A rank hosts several.
class Node {
 public:
  virtual ~Node() = default;
  virtual NodeId id() const = 0;
  /// A frame was announced; frames come in ascending order.
  virtual void begin_frame(const Announcement& announcement) = 0;
  /// Drops a frame that nobody wants any more: it ends without a picture once its tokens have come round.
  virtual void drop_frame(std::int64_t frame) = 0;
  /// Takes a message of a frame that has begun here. Throws RunError on stale ones.
  virtual void receive(Message message) = 0;
  /// Does a bounded piece of work; false when there is none to do now.
  virtual bool advance() = 0;
  /// True between two pieces of one slice's work.
  virtual bool amid_slice() const { return false; }
  /// True while no frame is under way here.
  virtual bool idle() const = 0;
  /// What this node waits for, in words; empty when for nothing.
  virtual std::string waiting_for() const = 0;
};

/// How nodes send: the host finds the way.
using Post = std::function<void(Message)>;

/// What a node is made from. The engine must outlive it.
struct NodeParts {
  int index;
  Layout layout;
  ProtocolOptions options;
  Engine& engine;
  Post post;
};
std::unique_ptr<Node> make_gp(NodeParts parts);
std::unique_ptr<Node> make_renderer(NodeParts parts);
/// What it posts, an announcement, a drop or a shutdown, goes to every rank, this one included. The source
/// must outlive it.
std::unique_ptr<Node> make_frame_buffer(NodeParts parts, FrameSource& source);

/// Says that a node cannot use messages of this kind.
[[noreturn]] inline void refuse(NodeId node, const Header& h) {
  throw RunError(
      fmt::format("{} cannot use a {} (from {})", to_string(node), name(h.kind), to_string(h.from())));
}

/// A node's part of a frame is over: its report to the frame buffer. Fills in the memory of the process.
inline Message make_report(NodeId node, std::int64_t frame, NodeStats stats) {
  stats.peak_memory = peak_memory_bytes();
  Bytes body = Message::body_buffer();
  append(body, stats);
  return Message(make_header(Kind::report, node, frame_buffer_id, frame), std::move(body));
}

/// What a node was doing for a while, and for which frame and step.
struct Turn {
  std::optional<Activity> activity;  ///< none: idle
  std::int64_t frame = 0;
  std::int32_t step = -1;
  double compositing = 0;  ///< the last part of a payload's seconds
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
    if (trace_ == nullptr || !turn.activity) return;
    const double composited = std::max(begin, now - turn.compositing);
    trace_->add(*turn.activity, turn.frame, turn.step, begin, composited);
    if (composited < now) trace_->add(Activity::composite, turn.frame, turn.step, composited, now);
  }

  /// Puts a moment into the timeline.
  void mark(Moment moment, std::int64_t frame, std::int32_t step, std::int32_t renderer) {
    if (trace_ != nullptr) trace_->mark(moment, frame, step, renderer, now_seconds());
  }

 private:
  NodeTrace* trace_;
  double last_time_;
};

}  // namespace ringsplat

#pragma once
#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/byte_stream.hpp"
#include "base/process.hpp"
#include "net/message.hpp"
#include "protocol/engine.hpp"
#include "protocol/protocol_options.hpp"
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

/// What a GP or a Renderer is made from. The engine must outlive it.
struct NodeParts {
  int index;
  Layout layout;
  ProtocolOptions options;
  Engine& engine;
  Post post;
};
std::unique_ptr<Node> make_gp(NodeParts parts);
std::unique_ptr<Node> make_renderer(NodeParts parts);
/// `announce` carries an announcement, a drop or a shutdown to every rank, this one included. The engine and
/// the source must outlive it.
std::unique_ptr<Node> make_frame_buffer(const Layout& layout, const ProtocolOptions& options, Engine& engine,
                                        FrameSource& source, Post announce);

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

}  // namespace ringsplat

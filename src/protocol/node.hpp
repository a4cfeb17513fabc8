#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "net/message.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// A state machine that reacts to messages, works in bounded pieces and never blocks. A rank hosts several.
class Node {
 public:
  virtual ~Node() = default;
  virtual NodeId id() const = 0;
  /// A frame was announced; frames come in ascending order.
  virtual void begin_frame(const Announcement& announcement) = 0;
  /// Drops a frame that nobody wants any more: it ends without a picture once its tokens have come round.
  virtual void drop_frame(std::int64_t frame) = 0;
  /// Takes a message for this node. Keeps early messages; throws RunError on stale ones.
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

/// Messages that overtake the announcement of their frame. The network does not keep their order.
class EarlyMessages {
 public:
  /// Takes a message of a frame that was not announced yet; false for others, which are left alone.
  bool keep(Message& message);
  /// Frame `frame` was announced: gives back all, to be received again.
  std::vector<Message> release(std::int64_t frame);

 private:
  std::int64_t next_frame_ = 0;
  std::vector<Message> kept_;
};

/// Says that a node cannot use messages of this kind.
[[noreturn]] void refuse(NodeId node, const Header& header);

/// A node's part of a frame is over: its report to the frame buffer. Fills in the memory of the process.
Message make_report(NodeId node, std::int64_t frame, NodeStats stats);

}  // namespace ringsplat

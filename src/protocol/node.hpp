#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "protocol/engine.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// A state machine that is given messages and time and never blocks. Several live on one rank.
class Node {
 public:
  virtual ~Node() = default;
  virtual NodeId id() const = 0;
  /// A frame was announced; frames come in ascending order.
  virtual void begin_frame(const Announcement& announcement) = 0;
  /// Nobody wants the frame any more: it ends as soon as its tokens have come round, without a picture.
  virtual void drop_frame(std::int64_t frame) = 0;
  /// Takes a message for this node. Early messages wait inside; stale ones throw RunError.
  virtual void receive(Message message) = 0;
  /// Does a bounded piece of work; false when there is none to do now.
  virtual bool advance() = 0;
  /// True between two pieces of one slice's work.
  virtual bool amid_slice() const { return false; }
  /// What this node waits for, in words; empty when for nothing.
  virtual std::string waiting_for() const = 0;
};

/// How nodes send: the host finds the way.
using Post = std::function<void(Message)>;

}  // namespace ringsplat

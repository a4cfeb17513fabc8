#pragma once
#include <optional>

#include "ringsplat/net/message.hpp"

namespace ringsplat {

/// Moves messages between ranks. Delivers each message once and whole, in any order. One
/// thread uses it. Only a transport waits: nodes never block.
class Transport {
 public:
  virtual ~Transport() = default;
  virtual int rank() const = 0;
  virtual int ranks() const = 0;
  /// Takes the message over and returns at once. `destination` is another rank.
  virtual void send(int destination, Message message) = 0;
  /// A message that has arrived, if any.
  virtual std::optional<Message> receive() = 0;
  /// True when every message sent has left this rank's memory.
  virtual bool sends_done() = 0;
  /// Gives time away until something may have happened; returns after about a millisecond at the latest, on a
  /// rank that has nothing to do after ten.
  virtual void wait_next() = 0;
  /// Says that work was done since the last wait, so the next wait starts eager again.
  virtual void note_progress() {}
  /// Says that only the first `ranks` ranks have anything to do from now on, so that the others keep off the
  /// cores.
  virtual void only_first_work(int ranks) { static_cast<void>(ranks); }
};

}  // namespace ringsplat

#pragma once
#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "net/message.hpp"

namespace ringsplat {

/// Moves messages between ranks. Delivers each message once and whole, in any order. Used by one thread. Only
/// a transport waits; nodes never block.
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
  /// A rank's turn begins: lets go of messages that were to leave later; false when there were none.
  virtual bool begin_turn() { return false; }
  /// Whether messages came, since it was last asked, that receive() does not return.
  virtual bool relayed() { return false; }
  /// What messages wait for on this rank, in words; empty when none does.
  virtual std::string waiting_for() const { return {}; }
  /// Waits until something may have happened: a millisecond at most, or up to forty on a rank without work.
  virtual void wait_next() = 0;
  /// Waits as wait_next() while no frame is under way on this rank, and then ever longer, up to some
  /// milliseconds. `sleep`, if any, does the sleeping; it may end sooner.
  using Sleep = std::function<void(std::chrono::nanoseconds)>;
  virtual void wait_between_frames(const Sleep& /*sleep*/) { wait_next(); }
  /// Tells that work was done since the last wait, so that the next wait begins by polling again.
  virtual void note_progress() {}
  /// Tells that from now on only the first `ranks` ranks have work, so that the others keep off the cores.
  virtual void only_first_work(int /*ranks*/) {}
};

/// Forwards to another transport what not every derived one changes.
class TransportDecorator : public Transport {
 public:
  /// `inner` must outlive it.
  explicit TransportDecorator(Transport& inner) : inner_(inner) {}
  int rank() const override { return inner_.rank(); }
  int ranks() const override { return inner_.ranks(); }
  std::optional<Message> receive() override { return inner_.receive(); }
  bool sends_done() override { return inner_.sends_done(); }
  bool begin_turn() override { return inner_.begin_turn(); }
  bool relayed() override { return inner_.relayed(); }
  std::string waiting_for() const override { return inner_.waiting_for(); }
  void wait_next() override { inner_.wait_next(); }
  void wait_between_frames(const Sleep& sleep) override { inner_.wait_between_frames(sleep); }
  void note_progress() override { inner_.note_progress(); }
  void only_first_work(int ranks) override { inner_.only_first_work(ranks); }

 protected:
  Transport& inner_;
};

}  // namespace ringsplat

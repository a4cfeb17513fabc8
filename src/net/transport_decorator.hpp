#pragma once
#include <utility>

#include "net/transport.hpp"

namespace ringsplat {

/// Forwards everything to another transport; derived ones override what they change.
class TransportDecorator : public Transport {
 public:
  /// `inner` must outlive it.
  explicit TransportDecorator(Transport& inner) : inner_(inner) {}
  int rank() const override { return inner_.rank(); }
  int ranks() const override { return inner_.ranks(); }
  void send(int destination, Message message) override { inner_.send(destination, std::move(message)); }
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

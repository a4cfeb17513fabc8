#pragma once
#include <deque>
#include <memory>
#include <utility>

#include "net/mesh_lock_step.hpp"
#include "net/transport_decorator.hpp"

namespace ringsplat {

/// Keeps the payloads and tokens of this rank's nodes until their step of a lock-step clock.
class LockStepTransport final : public TransportDecorator {
 public:
  /// Ranks of one process share a clock; others have one each.
  LockStepTransport(Transport& links, std::shared_ptr<LockStep> clock)
      : TransportDecorator(links), clock_(std::move(clock)) {}

  void send(int destination, Message message) override {
    if (clock_->may_leave(message.header)) {
      inner_.send(destination, std::move(message));
      return;
    }
    ++clock_->kept;
    kept_.push_back({destination, std::move(message)});
  }
  bool begin_turn() override {
    bool released = inner_.begin_turn();
    for (auto kept = kept_.begin(); kept != kept_.end();) {
      if (!clock_->may_leave(kept->message.header)) {
        ++kept;
        continue;
      }
      --clock_->kept;
      inner_.send(kept->destination, std::move(kept->message));
      kept = kept_.erase(kept);
      released = true;
    }
    return released;
  }
  void wait_next() override { kept_.empty() ? inner_.wait_next() : clock_->wait(); }
  void wait_between_frames(const Sleep& sleep) override {
    kept_.empty() ? inner_.wait_between_frames(sleep) : clock_->wait();
  }

 private:
  struct Kept {
    int destination;
    Message message;
  };
  std::shared_ptr<LockStep> clock_;
  std::deque<Kept> kept_;
};

}  // namespace ringsplat

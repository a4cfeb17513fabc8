#pragma once
#include <cstdint>
#include <list>
#include <map>
#include <utility>

#include "net/loopback.hpp"
#include "net/mesh.hpp"
#include "net/transport.hpp"

namespace ringsplat::test {

/// Moves all tokens one GP per step, whatever the delays: the clock that the proof in mesh.hpp assumes, for
/// runs in one process. The tokens form a train, in the order in which the front slice's owner first uses
/// them. The k-th one's payload of traversal step s leaves in step k + s after the frame's start, and the
/// token itself in the step after.
class LockStep {
 public:
  /// True when a message may leave its node now.
  bool may_leave(const Header& h) {
    if (h.kind != Kind::payload && h.kind != Kind::token) return true;
    const TokenPlace place = *token_place(h);
    if (h.frame != frame_) {
      frame_ = h.frame;
      frame_start_ = now_;
      start_.clear();
    }
    const auto [start, is_new] = start_.try_emplace(place.renderer);
    if (is_new) {
      // The front slice's owner forms the train; the others get each token in its step.
      const int held = h.kind == Kind::token ? place.step - 1 : place.step;
      start->second = held == 0 ? frame_start_ + std::int64_t(start_.size()) - 1 : now_ - held;
    }
    return now_ >= start->second + place.step;
  }
  /// Steps of the clock so far.
  std::int64_t now() const { return now_; }
  /// Advances the clock by one step; call it when everything that may leave has arrived.
  void advance() { ++now_; }
  /// Number of messages kept at their nodes until their step.
  int kept = 0;

 private:
  std::int64_t now_ = 0;
  std::int64_t frame_ = -1, frame_start_ = 0;  ///< of the frame under way; there is only one at a time
  std::map<int, std::int64_t> start_;          ///< by Renderer: when its token is at step 0
};

/// Keeps the payloads and tokens of this rank's nodes until their step of a lock-step clock.
class LockStepTransport final : public TransportDecorator {
 public:
  /// `clock`: of all ranks; it must outlive this.
  LockStepTransport(Transport& links, LockStep& clock) : TransportDecorator(links), clock_(clock) {}

  void send(int destination, Message message) override {
    if (clock_.may_leave(message.header)) {
      inner_.send(destination, std::move(message));
      return;
    }
    ++clock_.kept;
    kept_.push_back({destination, std::move(message)});
  }
  bool begin_turn() override {
    const bool released = inner_.begin_turn();
    const auto left = kept_.remove_if([this](Kept& kept) {
      const bool leaves = clock_.may_leave(kept.message.header);
      if (leaves) inner_.send(kept.destination, std::move(kept.message));
      return leaves;
    });
    clock_.kept -= int(left);
    return released || left > 0;
  }

 private:
  struct Kept {
    int destination;
    Message message;
  };
  LockStep& clock_;
  std::list<Kept> kept_;
};

/// Runs in step with the clock, of one frame at a time. `on_link_use`: called with every mesh link in use.
template <class OnLinkUse>
LoopbackOptions in_step(LoopbackOptions loopback, LockStep& clock, const OnLinkUse& on_link_use) {
  loopback.between.pace = [&clock](Transport& links) {
    return std::make_unique<LockStepTransport>(links, clock);
  };
  loopback.between.on_link_use = [&clock, on_link_use](const Link& link, const Header& header) {
    on_link_use(clock.now(), link, header);
  };
  loopback.at_standstill = [&clock] {
    if (clock.kept > 0) clock.advance();
    return clock.kept > 0;
  };
  return loopback;
}

}  // namespace ringsplat::test

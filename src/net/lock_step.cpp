#include "net/lock_step.hpp"

#include <cmath>

#include "base/clock.hpp"

namespace ringsplat {

bool LockStep::may_leave(const Header& h) {
  if (h.kind != Kind::payload && h.kind != Kind::token) return true;
  const TokenPlace place = *token_place(h);
  const bool timed = step_seconds_ > 0;
  if (timed) now_ = std::llround(std::floor(now_seconds() / step_seconds_));
  if (h.frame != frame_) {
    frame_ = h.frame;
    frame_start_ = timed ? now_ + 1 : now_;
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

void LockStep::record(const Link& link, const Header& header) const {
  if (observer_) observer_(now_, link, header);
}

}  // namespace ringsplat

#include "ringsplat/net/mesh_lock_step.hpp"

namespace ringsplat {

bool LockStep::may_leave(const Header& h) {
  if (h.kind != Kind::payload && h.kind != Kind::token) return true;
  if (h.frame != frame_) {
    frame_ = h.frame;
    frame_start_ = now_;
    places_.clear();
  }
  const int place = places_.try_emplace(h.renderer, static_cast<int>(places_.size())).first->second;
  return now_ >= frame_start_ + place + h.step;
}

void LockStep::record(const Link& link, const Header& header) const {
  if (observer_) observer_(now_, link, header);
}

}  // namespace ringsplat

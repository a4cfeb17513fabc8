#pragma once
#include <algorithm>
#include <utility>

#include "base/clock.hpp"

namespace ringsplat {

/// Seconds since `last`, which becomes now, for those who look again and again whether something moves. At
/// most `longest`, more than a look takes: a process that was suspended meanwhile, as by a batch system, has
/// not waited.
inline double seconds_awake(double& last, double longest) {
  const double now = now_seconds();
  return std::min(now - std::exchange(last, now), longest);
}

}  // namespace ringsplat

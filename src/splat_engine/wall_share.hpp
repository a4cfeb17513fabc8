#pragma once
#include <algorithm>

namespace ringsplat {

/// What of a piece's `wall` seconds goes to a part of it, when its threads were busy for `busy` seconds in
/// sum and spent `part` of them on it. So a node's seconds add up to what the clock on the wall says, however
/// many threads it has.
inline double wall_share(double wall, double part, double busy) {
  return busy > 0 ? wall * std::min(part / busy, 1.0) : 0.0;
}

}  // namespace ringsplat

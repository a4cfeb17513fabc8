#pragma once
#include <algorithm>

namespace ringsplat {

/// Share of a piece's `wall` seconds for one part of its work: its threads were busy for `busy` seconds in
/// sum, `part` of them on that part. So a node's seconds add up to wall-clock time with any number of
/// threads.
inline double wall_share(double wall, double part, double busy) {
  return busy > 0 ? wall * std::min(part / busy, 1.0) : 0.0;
}

}  // namespace ringsplat

#pragma once
#include <vector>

#include "classify/empty_space.hpp"

namespace ringsplat {

/// Cuts rows 0 … height − 1 into at most `most` bands with about equal numbers of possibly visible voxels.
/// Band k has rows bounds[k] … bounds[k + 1] − 1, at least one. There are fewer bands, down to one, when a
/// band would not be worth a thread. A slice with nothing to see has no bands: {0}.
std::vector<int> row_bounds(const SliceRuns& runs, int height, int most);

}  // namespace ringsplat

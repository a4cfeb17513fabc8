#pragma once
#include <vector>

#include "classify/empty_space.hpp"

namespace ringsplat {

/// Cuts rows 0 … height − 1 into at most `most` bands of about as many voxels that may be visible: band k has
/// rows bounds[k] … bounds[k + 1] − 1, at least one. Fewer bands, down to one, when there is too little for a
/// band to be worth a thread. A slice with nothing to see has no rows: {0}.
std::vector<int> row_bounds(const SliceRuns& runs, int height, int most);

}  // namespace ringsplat

#pragma once
#include <string>
#include <vector>

#include "app/launch.hpp"

namespace ringsplat::app {

/// Warns on rank 0 when a rank's threads have to share cores. All ranks call it.
void warn_of_shared_cores(int threads, Launch& launch);

/// What to tell the user when ranks of `threads` threads may run on so many cores each (`cores`, by rank; one
/// without ranks); empty when all is well.
std::string shared_cores_warning(int threads, const std::vector<int>& cores, bool over_mpi);

}  // namespace ringsplat::app

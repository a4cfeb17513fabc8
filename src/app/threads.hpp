#pragma once
#include <string>
#include <vector>

#include "app/launch.hpp"

namespace ringsplat::app {

/// Warns on rank 0 when a rank's threads have to share cores. All ranks call it.
void warn_of_shared_cores(int threads, Launch& launch);

/// The warning when ranks of `threads` threads have too few cores; empty when all is well. `cores`: cores
/// that each rank may run on, by rank; one entry without ranks.
std::string shared_cores_warning(int threads, const std::vector<int>& cores, bool over_mpi);

}  // namespace ringsplat::app

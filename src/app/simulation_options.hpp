#pragma once
#include "app/launch.hpp"

namespace ringsplat::app {

/// Reads the machine that --machine names and fits the protocol to a simulated run. All ranks call it. Throws
/// InputError when the file is bad, or an option needs a simulation that this is not; warns when --machine
/// has no effect.
void prepare_simulation(RunOptions& options, Launch& launch);

}  // namespace ringsplat::app

#pragma once
#include "program/launch.hpp"

namespace ringsplat::app {

/// Reads the machine that --machine names and adapts the protocol's options to a simulated run. All ranks
/// call it. Throws InputError when the file is bad, or when an option needs a simulation and this is none;
/// warns when --machine has no effect.
void prepare_simulation(RunOptions& options, Launch& launch);

}  // namespace ringsplat::app

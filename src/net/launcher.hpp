#pragma once
#include <optional>

namespace ringsplat {

/// True when a launcher (mpirun, srun …) started this process, by what launchers put into its environment.
bool started_by_launcher();

/// How many processes that launcher started; nothing when it does not say.
std::optional<int> launched_processes();

/// True when this program runs under SimGrid's simulated MPI.
bool simulated();

}  // namespace ringsplat

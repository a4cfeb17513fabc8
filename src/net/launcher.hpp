#pragma once
#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>

// A function of SimGrid's. Weak: null when the program is linked with another MPI.
extern "C" void smpi_execute_benched(double seconds) __attribute__((weak));

namespace ringsplat {

/// True when a launcher (mpirun, srun …) started this process, by what launchers put into its environment.
inline bool started_by_launcher() {
  // What Open MPI, MPICH's hydra, PMIx and Slurm tell the processes they start.
  constexpr std::array variables{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMI_RANK", "PMIX_RANK",
                                 "MPI_LOCALNRANKS"};
  return std::any_of(variables.begin(), variables.end(),
                     [](const char* variable) { return std::getenv(variable) != nullptr; });
}

/// How many processes that launcher started; nothing when it does not say.
inline std::optional<int> launched_processes() {
  for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* const text = std::getenv(variable); text != nullptr && std::atoi(text) > 0)
      return std::atoi(text);
  return {};
}

/// True when this program runs under SimGrid's simulated MPI.
inline bool simulated() { return smpi_execute_benched != nullptr; }

}  // namespace ringsplat

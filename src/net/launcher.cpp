#include "net/launcher.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace ringsplat {

bool started_by_launcher() {
  // What Open MPI, MPICH's hydra, PMIx and Slurm tell the processes they start.
  constexpr std::array variables{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMI_RANK", "PMIX_RANK",
                                 "MPI_LOCALNRANKS"};
  return std::any_of(variables.begin(), variables.end(),
                     [](const char* variable) { return std::getenv(variable) != nullptr; });
}

std::optional<int> launched_processes() {
  for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* const text = std::getenv(variable); text != nullptr && std::atoi(text) > 0)
      return std::atoi(text);
  return {};
}

}  // namespace ringsplat

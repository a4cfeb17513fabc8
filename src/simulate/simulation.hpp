#pragma once
#include <optional>

#include "session/render.hpp"
#include "simulate/machine.hpp"

namespace ringsplat {

/// Options of runs that measure time or counts instead of making pictures (docs/simulation.md).
struct SimulationOptions {
  std::optional<Machine> machine = {};  ///< nodes charge its costs to the simulated clock
  bool count_only = false;  ///< payloads have their true size but carry only counts, and nothing is drawn
  double voxel_weight = 1;  ///< with count_only: voxels of a slice that each voxel stands for
};

/// Makes a run a simulated one, or one that only counts.
void simulate(const SimulationOptions& simulation, EngineOptions& options);

}  // namespace ringsplat

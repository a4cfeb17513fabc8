#pragma once
#include <functional>
#include <memory>
#include <span>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"
#include "simulate/machine.hpp"

namespace ringsplat {

/// How many slices a payload is of.
using SlicesOf = std::function<int(std::span<const std::byte> payload)>;

/// An engine whose work takes as long on the simulated clock as `machine` says. A step is complete once its
/// time has passed. Time passes in pieces, so that the rank handles messages in between.
std::unique_ptr<Engine> make_charged_engine(std::unique_ptr<Engine> inner, const Machine& machine,
                                            SlicesOf slices_of);

/// The engine of runs that only count. Payloads are as long as they would be, but hold only the number of
/// items and the tiles that these are for; tiles are black. Each voxel stands for `voxel_weight` voxels of
/// its slice. A Renderer's tiles from the 64th on count as one.
std::unique_ptr<Engine> make_counting_engine(const EngineSetup& setup, double voxel_weight);

/// How many slices such a payload is of.
int slices_counted(std::span<const std::byte> payload);

}  // namespace ringsplat

#pragma once
#include <memory>
#include <span>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// The engine of runs that only count. Payloads are as long as they would be, but hold only the number of
/// items and the tiles that these are for; tiles are black. Each voxel stands for `voxel_weight` voxels of
/// its slice. A Renderer's tiles from the 64th on count as one.
std::unique_ptr<Engine> make_counting_engine(const EngineSetup& setup, double voxel_weight);

/// How many slices such a payload is of.
int slices_counted(std::span<const std::byte> payload);

}  // namespace ringsplat

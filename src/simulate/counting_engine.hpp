#pragma once
#include <memory>

#include "protocol/engine.hpp"

namespace ringsplat {

/// The engine of runs that only count. Payloads are as long as `inner`'s would be, but hold only the number
/// of items and the tiles that these are for; tiles are black. Each voxel stands for `voxel_weight` voxels of
/// its slice. A Renderer's tiles from the 64th on count as one.
std::unique_ptr<Engine> make_counting_engine(std::unique_ptr<Engine> inner, double voxel_weight);

}  // namespace ringsplat

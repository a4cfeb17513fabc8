#pragma once
#include <memory>

#include "protocol/engine.hpp"

namespace ringsplat {

/// The engine of runs that only count: payloads have the bytes that `inner`'s would have, but tell no more than how
/// many items they stand for and of which tiles, and tiles are black. Each voxel stands for `voxel_weight` voxels of
/// its slice. Of a Renderer's tiles, those from the 64th on count as one.
std::unique_ptr<Engine> make_counting_engine(std::unique_ptr<Engine> inner, double voxel_weight);

}  // namespace ringsplat

#pragma once
#include <memory>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"
#include "splat_engine/splat_frame.hpp"

namespace ringsplat {

/// The engines of one rank, whose encoders make measured payloads (simulate/meter.hpp), which nobody can
/// draw. Each voxel stands for `voxel_weight` of its slice: sheets have as many blocks as those would
/// make; splats are as many as voxels, with kernels as large as those would have.
std::unique_ptr<Engine> make_measured_engines(const EngineSetup& setup, double voxel_weight);

class RegionDealer;

/// A frame of such splats; without a `dealer` regions are dealt in turn.
std::shared_ptr<const SplatFrame> make_weighed_frame(const FrameSpec& spec, const Grid& grid,
                                                     SliceDealing dealing, int renderers, double voxel_weight,
                                                     RegionDealer* dealer = nullptr);

}  // namespace ringsplat

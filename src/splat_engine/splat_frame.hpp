#pragma once
#include <cstdint>
#include <memory>

#include "frame/frame_geometry.hpp"
#include "protocol/engine.hpp"
#include "volume/slice_dealing.hpp"

namespace ringsplat {

/// A frame as the nodes of a rank share it: what was announced, and what follows from it.
struct SplatFrame {
  std::int64_t number = 0;
  Shown shown;
  Splats splats;
  FrameGeometry geometry;
  Footprint footprint;
  FramePlan plan;
  double voxel_weight = 1;  ///< as EngineSetup's
};

class RegionDealer;

/// `spec` must be of this method; without a `dealer` regions are dealt in turn. Throws InputError when its
/// view cannot be drawn. `voxel_weight`: as EngineSetup's.
std::shared_ptr<const SplatFrame> make_splat_frame(const FrameSpec& spec, const Grid& grid,
                                                   SliceDealing dealing, int renderers,
                                                   RegionDealer* dealer = nullptr, double voxel_weight = 1);

}  // namespace ringsplat

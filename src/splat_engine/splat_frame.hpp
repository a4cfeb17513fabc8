#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "frame/frame_geometry.hpp"
#include "protocol/engine.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "splat/footprint.hpp"
#include "volume/slice_dealing.hpp"

namespace ringsplat {

/// A frame as the nodes of a rank share it: what was announced, and what follows from it.
struct SplatFrame {
  std::int64_t number = 0;
  Shown shown;
  Splats splats;
  FrameGeometry geometry;
  std::vector<int> drawers;  ///< by region of the geometry: the Renderer that draws it, or nobody
  Footprint footprint;
  FramePlan plan;
};

class RegionDealer;

/// `spec` must be of this method, and `geometry` made of it; without a `dealer` regions are dealt in turn.
std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, FrameGeometry geometry,
                                             SliceDealing dealing, int renderers,
                                             RegionDealer* dealer = nullptr);

}  // namespace ringsplat

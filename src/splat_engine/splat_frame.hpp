#pragma once
#include "engine_parts/frame_engine.hpp"
#include "splat/footprint.hpp"

namespace ringsplat {

struct SplatFrame : SharedFrame {
  using SharedFrame::SharedFrame;

  Splats splats;
  Footprint footprint;
};

/// `spec` must be of this method, and `geometry` made of it; without a `dealer` regions are dealt in turn.
std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, FrameGeometry geometry,
                                             SliceDealing dealing, int renderers,
                                             RegionDealer* dealer = nullptr);

}  // namespace ringsplat

#pragma once
#include <cstdint>
#include <memory>

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
  Footprint footprint;
  FramePlan plan;
};

class RegionDealer;

/// `spec` must be of this method; without a `dealer` regions are dealt in turn. Throws InputError when its
/// view cannot be drawn.
std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, const Grid& grid, SliceDealing dealing,
                                             int renderers, RegionDealer* dealer = nullptr);
/// The same of a geometry that was made of `spec`.
std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, FrameGeometry geometry,
                                             SliceDealing dealing, int renderers,
                                             RegionDealer* dealer = nullptr);

}  // namespace ringsplat

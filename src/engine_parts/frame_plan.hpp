#pragma once
#include "frame/frame_geometry.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// What the protocol knows of a frame: slices are dealt in turn, and a tile is a region of the image plane.
FramePlan plan_of(const FrameGeometry& geometry, int gps, int renderers);

}  // namespace ringsplat

#pragma once
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// What GPs must know of their slices to draw a frame: voxels' normals for lit splats; for sheets, ranges of
/// what lies between voxels.
bool needs_normals(const FrameSpec& spec);
bool needs_cell_ranges(const FrameSpec& spec);

}  // namespace ringsplat

#pragma once
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/sheet_frame.hpp"

namespace ringsplat {

/// Phong's reflection for gradients that are differences of plane numbers along u, v and the traversed axis.
/// `most`: the largest number; gradients are scaled by it so that their squares neither overflow nor vanish.
/// `of_value`: how much larger a difference of such numbers is than that of values.
GradientLight gradient_light(const SheetFrame& frame, double most, double of_value);

/// Throws InputError when the slices are too large or too oblique for positions of 32 bits.
SheetRays make_sheet_rays(const SheetFrame& frame);

/// A frame's clip plane in its slices.
SheetPlane make_sheet_plane(const LatticePlane& plane, const FrameGeometry& geometry);

/// A slab without its planes. `step`: of its front; -1: the half slice before the first one.
SheetSlab make_slab(const SheetFrame& frame, const SheetRays& rays, int step);

}  // namespace ringsplat

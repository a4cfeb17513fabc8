#pragma once
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/sheet_frame.hpp"

namespace ringsplat {

/// The rays of a frame's pixels in its slices.
struct SheetRays {
  RayGrid grid;
  double shear[2] = {};  ///< voxels along u and v that slice 0 lies beside slice 1, seen along a ray
  bool patches = false;  ///< SheetPaint::patches
};
/// Throws InputError when the slices are too large or too oblique for positions of 32 bits.
SheetRays make_sheet_rays(const SheetFrame& frame);

/// A slab without its planes. `step`: of its front; -1: the half slice before the first one.
SheetSlab make_slab(const SheetFrame& frame, const SheetRays& rays, int step);

}  // namespace ringsplat

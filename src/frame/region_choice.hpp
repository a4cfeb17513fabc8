#pragma once
#include "frame/frame_geometry.hpp"

namespace ringsplat {

/// Squares suit splats, which regions cut; low strips share out evenly what costs by the pixel.
enum class RegionForm { square, flat };

/// Sets the regions of a geometry that is otherwise complete, and which of them voxels can reach. The
/// picture's bits do not depend on it.
void lay_regions(FrameGeometry& geometry, const Division& division, RegionForm form);

/// The regions that the volume's voxels can reach, in columns and rows of regions.
PixelRect reached_regions(const FrameGeometry& geometry, const Regions& regions);

}  // namespace ringsplat

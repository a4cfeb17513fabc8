#pragma once
#include "frame/frame_geometry.hpp"

namespace ringsplat {

/// Puts into a geometry that has all else how the image plane is cut and which regions voxels can reach. The
/// picture's bits do not depend on it.
void lay_regions(FrameGeometry& geometry, const Division& division);

}  // namespace ringsplat

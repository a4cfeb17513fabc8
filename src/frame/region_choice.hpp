#pragma once
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// Puts into a geometry that has all else how the image plane is cut and which regions voxels can reach. The
/// picture's bits do not depend on it.
void lay_regions(FrameGeometry& geometry, const FrameSpec& spec);

}  // namespace ringsplat

#pragma once
#include "ringsplat/base/image.hpp"

namespace ringsplat::app {

/// a − b per channel times `scale` (signed), alpha 1; absolute values when `absolute`. Both images have the
/// same size.
Image difference_image(const Image& a, const Image& b, double scale, bool absolute);

}  // namespace ringsplat::app

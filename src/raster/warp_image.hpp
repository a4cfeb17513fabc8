#pragma once
#include "ringsplat/base/image.hpp"
#include "screen/regions.hpp"
#include "view/slice_plane.hpp"

namespace ringsplat {

/// Warps the image in the slices' plane to a picture of width × height pixels (Lacroute and Levoy 1994,
/// section 2). Each pixel takes the plane's value at its centre, interpolated with Catmull and Rom's cubic
/// (Keys 1981, a = −½) in premultiplied colours and opacity. The cubic has negative lobes, so the result is
/// clamped: opacity to [0, 1] and colours to [0, opacity].
///
/// `window` holds all pixels of `plane` that are not transparent. Pixels of the picture that see none of them
/// are transparent. A pixel's operations are the same whatever the vector width, so its bits do not depend on
/// the processor.
Image warp_image(const Image& plane, const PixelWindow& window, const PlaneWarp& warp, int width, int height);

}  // namespace ringsplat

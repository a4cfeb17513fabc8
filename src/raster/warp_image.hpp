#pragma once
#include "ringsplat/base/image.hpp"
#include "ringsplat/view/slice_plane.hpp"
#include "screen/pixel_window.hpp"

namespace ringsplat {

/// The picture of width × height pixels of the image in the slices' plane (Lacroute and Levoy 1994, section
/// 2): every pixel takes what lies at its centre's place, interpolated with Catmull and Rom's cubic (Keys
/// 1981, a = −½) in premultiplied colours and opacity; what the cubic's lobes bring below 0 or above is
/// clamped, opacity to [0, 1] and colours to [0, opacity].
///
/// Where the picture's columns lie in columns of the plane, along its rows first and then down the columns,
/// of four pixels each (Catmull and Smith 1980); otherwise of sixteen at once. Sums differ by roundings.
///
/// `window`: the pixels of `plane` that are not transparent lie in it. Pixels that see none of them are
/// transparent. A pixel's operations are the same whatever the vector width, so its bits do not
/// depend on the processor.
Image warp_image(const Image& plane, const PixelWindow& window, const PlaneWarp& warp, int width, int height);

}  // namespace ringsplat

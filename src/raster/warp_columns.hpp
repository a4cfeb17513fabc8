#pragma once
#include <span>

#include "raster/warp_row.hpp"
#include "ringsplat/base/image.hpp"

namespace ringsplat {

/// Fills a picture whose columns lie in columns of the plane: all of its rows have the same start_x and
/// step_x. This holds for x and y slices of an upright volume unless the picture is rolled, because the
/// camera's right is across the volume's axis. Two passes of four taps then do instead of sixteen taps
/// (Catmull and Smith 1980): along the plane's rows, which all need the same weights in a column of the
/// picture, then down the columns.
///
/// `rows`: all rows of the picture; their first taps lie in the plane's rows first_tap … last_tap.
void warp_columns(std::span<const WarpedRow> rows, int first_tap, int last_tap, Image& screen);

}  // namespace ringsplat

#pragma once
#include <span>

#include "raster/warp_row.hpp"
#include "ringsplat/base/image.hpp"

namespace ringsplat {

/// Fills the pixels of a picture whose columns lie in columns of the plane, so that start_x and step_x are
/// those of any of its rows: as the camera's right is across an upright volume's axis, they do for x and y
/// slices unless the picture is rolled. Two passes of four taps then do instead of sixteen (Catmull and Smith
/// 1980): along the plane's rows, which all need the same weights in a column of the picture, and down its
/// columns.
///
/// `rows`: all of the screen's; their first taps lie in the plane's rows first_tap … last_tap.
void warp_columns(std::span<const WarpedRow> rows, int first_tap, int last_tap, Image& screen);

}  // namespace ringsplat

#pragma once
#include <cstddef>
#include <span>

#include "ringsplat/base/image.hpp"

namespace ringsplat {

/// One row of the picture. The first tap of its pixel x lies at start + x · step in the plane, rounded down.
struct WarpedRow {
  const float* plane;         ///< RGBA
  std::ptrdiff_t row_floats;  ///< of the plane
  double start_x, start_y, step_x, step_y;
  int first, end;  ///< pixels to fill are first … end − 1; all their taps lie in the plane
};

/// Fills the row's pixels first … end − 1, each from sixteen pixels of the plane. `screen`: the row's first
/// pixel.
void warp_row(const WarpedRow& row, float* screen);

/// Fills a picture whose columns lie in columns of the plane: all of its rows have the same start_x and
/// step_x. This holds for x and y slices of an upright volume unless the picture is rolled, because the
/// camera's right is across the volume's axis. Two passes of four taps then do instead of sixteen taps
/// (Catmull and Smith 1980): along the plane's rows, which all need the same weights in a column of the
/// picture, then down the columns.
///
/// `rows`: all rows of the picture; their first taps lie in the plane's rows first_tap … last_tap.
void warp_columns(std::span<const WarpedRow> rows, int first_tap, int last_tap, Image& screen);

}  // namespace ringsplat

#pragma once
#include <cstddef>

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

/// Catmull and Rom's weights of the four taps as polynomials of the fraction: [power][tap] coefficients.
alignas(16) inline constexpr float cubic[4][4] = {
    {0, 1, 0, 0}, {-0.5F, 0, 0.5F, 0}, {1, -2.5F, 2, -0.5F}, {-0.5F, 1.5F, -1.5F, 0.5F}};

}  // namespace ringsplat

#include "sheet_engine/eye_grid.hpp"

#include <algorithm>
#include <cmath>

namespace ringsplat {

double EyeGrid::depth(double x, double y) const {
  return 1 + double(depth_x) * (x - double(central_x)) + double(depth_y) * (y - double(central_y));
}

double EyeGrid::slope(int i, double x, double y) const {
  return double(central_slope[i]) +
         (double(slope_x[i]) * (x - double(central_x)) + double(slope_y[i]) * (y - double(central_y))) /
             depth(x, y);
}

bool EyeGrid::spans_less(int x, int y, int side, int tile, double voxels) const {
  const double farthest = std::abs(double(to_middle)) + double(half_slices);
  double nearest = INFINITY, change[2] = {}, steep[2] = {};
  // Over a rectangle of pixels in front of the eye, depth and the numerators of slopes' derivatives are
  // linear and slopes are quotients of linear functions, so corners are their extremes.
  for (int corner = 0; corner < 4; ++corner) {
    const double px = x + (corner & 1) * (side - 1), py = y + (corner >> 1) * (side - 1),
                 here = depth(px, py);
    nearest = std::min(nearest, here);
    for (int i = 0; i < 2; ++i) {
      const double from_central = slope(i, px, py) - double(central_slope[i]);
      change[i] =
          std::max(change[i], std::abs(here * (double(slope_x[i]) - from_central * double(depth_x))) +
                                  std::abs(here * (double(slope_y[i]) - from_central * double(depth_y))));
      steep[i] = std::max(steep[i], std::abs(slope(i, px, py)));
    }
  }
  if (!(nearest > 0)) return false;
  for (int i = 0; i < 2; ++i) {
    const double pixel = change[i] / (nearest * nearest) * farthest;
    if (!((tile - 1) * pixel + steep[i] + 2 * double(position_error) < voxels)) return false;
  }
  return true;
}

}  // namespace ringsplat

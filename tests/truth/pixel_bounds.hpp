#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "truth/certified.hpp"
#include "truth_support.hpp"

namespace ringsplat::test {

// What bounds are apt to miss: values of 16³ voxels, and views.
inline double lumps(int x, int y, int z) {
  return lumps_in_ball((x + 0.5) / 16, (y + 0.5) / 16, (z + 0.5) / 16);
}
inline double holed(int x, int y, int z) {
  return (x + 2 * y + 3 * z) % 17 == 0 ? std::numeric_limits<double>::quiet_NaN() : lumps(x, y, z);
}
inline double endless(int x, int y, int z) {
  return (x * y + z) % 23 == 0 ? std::numeric_limits<double>::infinity() : lumps(x, y, z);
}
inline double block(int x, int y, int z) {
  return x > 3 && x < 12 && y > 3 && y < 12 && z > 3 && z < 12 ? 1.0 : 0.0;
}
inline const Camera cameras[] = {{.azimuth = 31, .elevation = 17, .roll = 9, .zoom = 1.1},
                                 {},
                                 {.azimuth = 45, .elevation = 35.264389682754654},
                                 {.azimuth = 12, .elevation = -50, .zoom = 3, .pan = {0.1, 0.2}},
                                 {.azimuth = 200, .elevation = 40, .fov = 40}};

/// Of pixels whose colour lies outside of their bounds.
inline std::size_t outside(const std::vector<truth::PixelBounds>& bounds,
                           const std::vector<truth::Rgba>& colours, double tolerance = 1e-10) {
  std::size_t count = 0;
  for (std::size_t p = 0; p < bounds.size(); ++p)
    count += glm::any(
        glm::greaterThan(glm::abs(bounds[p].nearest_to(colours[p]) - colours[p]), truth::Rgba(tolerance)));
  return count;
}

inline double share_within(const std::vector<truth::PixelBounds>& bounds, double width) {
  return double(std::ranges::count_if(bounds, [&](const auto& b) { return b.width() <= width; })) /
         double(bounds.size());
}

}  // namespace ringsplat::test

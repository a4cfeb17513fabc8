#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "truth/certified.hpp"

namespace ringsplat::test {

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

#pragma once
#include <cmath>

#include "support/scenes.hpp"

namespace ringsplat::test {

/// A body seen from an angle that no axis is parallel to.
inline FrameSpec oblique_view(int width, int height, int region_size) {
  FrameSpec spec{.how = Splats{}};
  spec.shown.camera = {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2};
  spec.shown.width = width;
  spec.shown.height = height;
  spec.division.region_size = region_size;
  spec.shown.transfer_function = ramp(20, 255, 0.3);
  return spec;
}

/// Root of the mean squared difference over all channels.
inline double rms_difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.rgba.size(); ++k) sum += std::pow(double(a.rgba[k] - b.rgba[k]), 2);
  return std::sqrt(sum / double(a.rgba.size()));
}

}  // namespace ringsplat::test

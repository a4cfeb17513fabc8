#pragma once
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// Sets of a method's settings, from the paper's method to the most exact one.
enum class Quality { paper, draft, normal, best };
constexpr const char* name(Quality quality) {
  constexpr const char* names[] = {"paper", "draft", "normal", "best"};
  return names[static_cast<int>(quality)];
}

/// The settings of a quality that draws sheets.
constexpr Sheets sheets_of(Quality quality) {
  if (quality == Quality::draft)
    return {.image_plane = ImagePlane::slices, .plane_samples = 1, .slabs = 2, .light_points = 1};
  if (quality == Quality::normal)
    return {.image_plane = ImagePlane::slices, .plane_samples = 1.5, .slabs = 2, .light_points = 2};
  return {.image_plane = ImagePlane::screen, .slabs = 3, .light_points = 2};
}

}  // namespace ringsplat

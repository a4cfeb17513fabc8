#pragma once
#include <array>
#include <cstdint>

#include "splat/footprint.hpp"
#include "view/slice_dda.hpp"

namespace ringsplat {

/// The positions of several voxels, in the form in which splats have them.
struct RunPlaces {
  static constexpr int capacity = 64;
  std::array<float, capacity> a, b, c;                    ///< coefficients from the anchor pixel's centre
  std::array<std::int32_t, capacity> anchor_x, anchor_y;  ///< minus the base
};

/// Places the voxels of columns first … first + count − 1 (at most RunPlaces::capacity) of the DDA's row. The
/// bits are those that anchor() and coefficients() give voxel by voxel. Anchors further than 2^31 pixels from
/// the base are clamped to that.
void place_run(const Footprint& footprint, const SliceDda& dda, std::uint32_t first, int count,
               std::int64_t base_x, std::int64_t base_y, RunPlaces& places);

}  // namespace ringsplat

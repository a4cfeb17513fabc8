#pragma once
#include <cstdint>
#include <glm/vec2.hpp>

#include "raster/region_image.hpp"

namespace ringsplat {

struct DrawCounts {
  std::uint64_t drawn = 0;    ///< splats that reached at least one pixel centre of the region with Q > 0
  std::uint64_t clipped = 0;  ///< splats that reached none
  std::uint64_t hidden = 0;   ///< splats that lie wholly under opaque tiles, not drawn
};

/// Sums the kernels of one slice's voxels in one region, then composites the sum behind the region's image
/// (Westover 1989; Neumann 1992, section 2.3).
///
/// Made for a frame and its kernel, and used for one region after another. A pixel's sum runs in the order of
/// the splats given, with the same operations whatever the vector width, so its bits do not depend on the
/// processor, the region size or the other splats.
class SliceSum {
 public:
  virtual ~SliceSum() = default;
  SliceSum() = default;
  SliceSum(const SliceSum&) = delete;
  SliceSum& operator=(const SliceSum&) = delete;

  /// Begins a slice of a region. `image` must outlive the slice; its frame has begun.
  virtual void begin(RegionImage& image) = 0;
  /// Puts the slice behind the image: C += (1 − A) c, A += (1 − A) a, with a and c clamped to [0, 1] and [0,
  /// a]. Leaves the sum empty, and costs nothing when it is. `voxel`: where a voxel of the slice lies in the
  /// image plane, in pixels; the exact normalisation divides a and c by the lattice's sum there first.
  /// Returns how many pixels it went through.
  virtual std::uint64_t composite(glm::dvec2 voxel) = 0;
};

}  // namespace ringsplat

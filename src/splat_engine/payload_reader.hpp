#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "raster/region_image.hpp"
#include "splat/run_sum.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {

/// One region's part of a payload.
struct PayloadPart {
  int region = 0;
  std::uint32_t voxels = 0;
  VoxelRuns runs{};
};

/// Splits a payload into its regions' parts, and sums a part's splats before it composites them.
class PayloadReader {
 public:
  /// The frame must outlive it.
  explicit PayloadReader(const SplatFrame& frame);

  /// The parts of a payload, one for each region, in ascending order. Checks the whole payload, so that a bad
  /// message leaves no half-drawn slice. Throws RunError unless it is a payload for regions whose `owned` is
  /// true.
  std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                 const std::function<bool(int region)>& owned) const;
  /// Goes to the first voxel of a part that parts() returned, for its region's image. The payload must stay
  /// valid until more() is false.
  void begin(int slice, const PayloadPart& part, RegionImage& image) {
    sum_.begin(image, slice);
    left_ = part.runs;
  }
  /// True while the part has voxels to draw.
  bool more() const { return left_.count > 0; }
  /// Draws at least one and about `most` of the part's next voxels.
  DrawCounts draw(std::uint32_t most);
  /// Puts what was drawn behind the image (SplatSum::composite).
  std::uint64_t composite() { return sum_.composite(); }

 private:
  const FrameGeometry& geometry_;
  RunSum sum_;
  VoxelRuns left_{};  ///< the part's blocks that are not drawn yet
};

}  // namespace ringsplat

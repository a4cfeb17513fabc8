#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "raster/region_image.hpp"
#include "splat/splat_sum.hpp"
#include "splat/voxel_run.hpp"
#include "view/slice_dda.hpp"

namespace ringsplat {

/// Sums a slice's voxels as splats, wherever they lie among the pixels: the view gives their positions.
class RunSum {
 public:
  /// `footprint` must outlive it. `dda`: of the frame's slices. `largest`: as SplatSum's.
  RunSum(const Footprint& footprint, SliceDda dda, const PixelRect& largest)
      : sum_(footprint, largest), footprint_(footprint), dda_(std::move(dda)) {}

  void begin(RegionImage& image, int slice) {  ///< as SplatSum's; of the slice with that index
    sum_.begin(image);
    slice_ = slice;
  }
  /// Adds voxels of the slice, in any order. Stops after `most` voxels or the block in which they end.
  DrawnBlocks draw(const VoxelRuns& blocks, std::uint64_t most);
  std::uint64_t composite() { return sum_.composite(); }

 private:
  SplatSum sum_;
  const Footprint& footprint_;
  SliceDda dda_;
  int slice_ = -1;
  std::vector<Splat> splats_;  ///< of the blocks being drawn
};

}  // namespace ringsplat

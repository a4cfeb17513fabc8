#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "raster/slice_buffer.hpp"
#include "splat/aligned_slice.hpp"
#include "splat/slice_sum.hpp"
#include "splat/sweep_voxels.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat {

struct DrawnBlocks {
  std::uint32_t blocks = 0;  ///< gone through
  DrawCounts counts;         ///< of their voxels
};

/// Sums a slice's voxels as they lie in their rows, where these are a whole number of pixels apart: they are
/// put into the slice buffer, and composite() convolves their rows with the kernels' weights. The same bits
/// as SplatSum of their splats, drawn row by row.
class VoxelSum final : public SliceSum {
 public:
  /// `memory` must outlive the sum, and no other sum may use it meanwhile.
  VoxelSum(AlignedFrame frame, RegionSize largest, SliceBufferMemory& memory);
  ~VoxelSum() override;

  void begin(RegionImage& image) override;
  /// Goes to a slice, given by its index, before the first of its regions.
  void begin_slice(int slice);
  /// Takes voxels of the slice, in any order but each only once. Stops after `most` voxels or the block in
  /// which they end. For FloatVoxel, HalfVoxel and ByteVoxel.
  template <class Voxel>
  DrawnBlocks draw(const VoxelBlocks<Voxel>& blocks, std::uint64_t most);
  std::uint64_t composite(glm::dvec2 voxel) override;

 private:
  PlacedVoxelRows placed();
  void forget_rows();

  AlignedFrame frame_;
  AlignedSlice slice_;
  int slice_index_ = -1;
  SliceBufferMemory& memory_;
  SliceBuffer buffer_;
  RegionImage* image_ = nullptr;        ///< of the region begun
  int left_, above_;                    ///< pixels of the buffer before the region; rows of anchors above it
  std::size_t words_;                   ///< of a bit for each pixel of a row, from the left margin's first on
  std::vector<std::uint64_t> filled_;   ///< [rows of anchors][words], between vectors that are 0
  std::vector<std::uint64_t> inside_;   ///< [words]: the region's pixels, whole pixel blocks
  std::vector<std::uint64_t> covered_;  ///< [words]: of a row, while it is swept
  int top_, bottom_;      ///< rows of anchors top_ … bottom_ − 1 hold voxels, the first surely
  int phase_x_ = 0;       ///< of the voxels' anchors, modulo their step
  bool reached_ = false;  ///< a voxel of the slice has a weight above zero in the region
};

}  // namespace ringsplat

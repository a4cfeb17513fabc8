#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "raster/slice_buffer.hpp"
#include "ringsplat/base/bytes.hpp"
#include "splat/frame_kernel.hpp"
#include "splat/slice_sum.hpp"
#include "splat/splat.hpp"

namespace ringsplat {

class SplatAdder;

/// Sums splats one by one into a slice buffer.
class SplatSum final : public SliceSum {
 public:
  /// `memory` must outlive the sum, and no other sum may use it meanwhile.
  SplatSum(const FrameKernel& kernel, RegionSize largest, SliceBufferMemory& memory);
  ~SplatSum() override;

  void begin(RegionImage& image) override;
  /// Adds whole splats; `splats` may have any alignment. (base_x, base_y): the pixel of the image plane from
  /// which their anchors count. Splats with a NaN or a coefficient that no footprint has count as clipped.
  DrawCounts draw(std::int32_t base_x, std::int32_t base_y, std::span<const std::byte> splats);
  std::uint64_t composite(glm::dvec2 voxel) override;

 private:
  std::span<const std::byte> without_hidden(std::int64_t left, std::int64_t top,
                                            std::span<const std::byte> splats);

  KernelReach reach_;
  std::shared_ptr<const LatticeSum> lattice_sum_;
  std::unique_ptr<SplatAdder> adder_;
  SliceBufferMemory& memory_;
  SliceBuffer buffer_;
  RegionImage* image_ = nullptr;  ///< of the region begun
  bool empty_ = true;             ///< the slice buffer is 0
  Bytes seen_;                    ///< the splats not hidden, of those being drawn
};

}  // namespace ringsplat

#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "raster/region_image.hpp"
#include "splat/splat_sum.hpp"

namespace ringsplat::test {

/// The kernel that is not normalised any further.
inline FrameKernel plain_kernel(const Footprint& footprint) { return {footprint, {}}; }
/// The kernel that is divided by the sum of its lattice's.
inline FrameKernel exact_kernel(const Footprint& footprint, const ViewTransform& view) {
  return {footprint, std::make_shared<LatticeSum>(footprint, lattice_block(view, Axis::z))};
}

/// One region with a sum of its own, as a Renderer with one region has them.
class RegionPainter {
 public:
  RegionPainter(int x0, int y0, int width, int height) : image_({x0, y0, x0 + width, y0 + height}) {}

  void begin_frame(const FrameKernel& kernel, float opaque_threshold = 0) {
    image_.begin_frame(opaque_threshold);
    sum_.reset();
    sum_.emplace(kernel, image_.rect());
    sum_->begin(image_);
  }
  void begin_frame(const Footprint& footprint, float opaque_threshold = 0) {
    begin_frame(plain_kernel(footprint), opaque_threshold);
  }
  DrawCounts draw(std::int32_t base_x, std::int32_t base_y, std::span<const std::byte> splats) {
    return sum_->draw(base_x, base_y, splats);
  }
  void composite(glm::dvec2 voxel = glm::dvec2(0.0)) { sum_->composite(voxel); }
  const OpaqueTiles& opaque_tiles() const { return image_.opaque_tiles(); }
  bool touched() const { return image_.touched(); }
  void read_tile(std::span<float> rgba) const { image_.read_tile(rgba); }

 private:
  RegionImage image_;
  std::optional<SplatSum> sum_;
};

}  // namespace ringsplat::test

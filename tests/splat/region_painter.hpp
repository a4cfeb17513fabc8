#pragma once
#include <memory>
#include <span>

#include "raster/region_image.hpp"
#include "splat/splat_sum.hpp"

namespace ringsplat::test {

/// One region with a sum of its own, as a Renderer with one region has them.
class RegionPainter {
 public:
  RegionPainter(int x0, int y0, int width, int height) : image_({x0, y0, x0 + width, y0 + height}) {}

  void begin_frame(const Footprint& footprint, float opaque_threshold = 0) {
    image_.begin_frame(opaque_threshold);
    sum_ = std::make_unique<SplatSum>(footprint, image_.rect());
    sum_->begin(image_);
  }
  DrawCounts draw(std::span<const Splat> splats) { return sum_->draw(splats); }
  void composite() { sum_->composite(); }
  const OpaqueTiles& opaque_tiles() const { return image_.opaque_tiles(); }
  bool touched() const { return image_.touched(); }
  void read_tile(std::span<float> rgba) const { image_.read_tile(rgba); }

 private:
  RegionImage image_;
  std::unique_ptr<SplatSum> sum_;
};

}  // namespace ringsplat::test

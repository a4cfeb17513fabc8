#include "engine_parts/frame_engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "frame/frame_spec_bytes.hpp"
#include "raster/warp_image.hpp"
#include "ringsplat/base/error.hpp"
#include "screen/regions.hpp"

namespace ringsplat {
namespace {

class PictureCanvas final : public Canvas {
 public:
  PictureCanvas(std::int64_t number, const Shown& shown, std::shared_ptr<const FrameGeometry> geometry,
                TakePicture take)
      : number_(number),
        width_(shown.width),
        height_(shown.height),
        geometry_(std::move(geometry)),
        take_(std::move(take)),
        image_(Image::uninitialised(geometry_->width, geometry_->height)),
        filled_{image_.width, image_.height, -1, -1},
        here_(std::size_t(geometry_->regions.count())) {}

  void take(int tile, std::span<const std::byte> bytes) override {
    const PixelRect rect = geometry_->regions.rect(tile);
    const std::size_t row_bytes = std::size_t(rect.width()) * 4 * sizeof(float);
    for (int y = 0; y < rect.height(); ++y)
      std::memcpy(image_.pixel(rect.x0, rect.y0 + y), bytes.data() + std::size_t(y) * row_bytes, row_bytes);
    filled_ = hull(filled_, {rect.x0, rect.y0, rect.x1 - 1, rect.y1 - 1});
    here_[std::size_t(tile)] = true;
  }

  void finish() override {
    clear_where_no_tile_came();
    if (const auto& warp = geometry_->warp) image_ = warp_image(image_, filled_, *warp, width_, height_);
    take_(number_, std::move(image_));
  }

 private:
  /// Clears only pixels without a tile, which are few.
  void clear_where_no_tile_came() {
    for (int region = 0; region < geometry_->regions.count(); ++region) {
      if (here_[std::size_t(region)]) continue;
      const PixelRect rect = geometry_->regions.rect(region);
      for (int y = rect.y0; y < rect.y1; ++y)
        std::fill(image_.pixel(rect.x0, y), image_.pixel(rect.x1, y), 0.0F);
    }
  }

  std::int64_t number_;
  int width_, height_;  ///< of the picture
  std::shared_ptr<const FrameGeometry> geometry_;
  TakePicture take_;
  Image image_;         ///< of the image plane
  PixelWindow filled_;  ///< part of it that tiles have filled
  std::vector<bool> here_;
};

}  // namespace

std::unique_ptr<Canvas> make_picture_canvas(std::int64_t number, const Shown& shown,
                                            std::shared_ptr<const FrameGeometry> geometry, TakePicture take) {
  return std::make_unique<PictureCanvas>(number, shown, std::move(geometry), std::move(take));
}

EncodeCounts left_out_of(const FrameGeometry& geometry, std::size_t steps) {
  const auto voxels = steps * std::uint64_t(geometry.grid.slice_voxels(geometry.traversal.axis));
  return {.voxels = voxels, .outside = voxels};
}

void check_loaded(const SliceStore& store, Axis traversed, std::int64_t number) {
  if (!store.keeps(traversed))
    throw RunError(
        fmt::format("frame {} traverses the {} axis, whose slices were not loaded", number, name(traversed)),
        "load it with --axes all");
}

void check_step(int renderer, int step, int slices) {
  if (step < 0 || step >= slices)
    throw RunError(
        fmt::format("Renderer {} got a payload for step {} of a traversal of {}", renderer, step, slices),
        "all ranks must run the same build");
}

FrameSpec announced_spec(const Announcement& a) {
  FrameSpec spec = decode_frame_spec(a.body);
  if (spec.frame != a.frame)
    throw RunError(fmt::format("rank 0 told of frame {} in a message about frame {}", spec.frame, a.frame));
  return spec;
}

}  // namespace ringsplat

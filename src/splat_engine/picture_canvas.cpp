#include <algorithm>
#include <cstring>
#include <utility>

#include "frame/frame_geometry.hpp"
#include "raster/warp_image.hpp"
#include "splat/encode.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {
namespace {

class PictureCanvas final : public Canvas {
 public:
  PictureCanvas(std::shared_ptr<const SplatFrame> frame, TakePicture take)
      : frame_(std::move(frame)),
        take_(std::move(take)),
        image_(Image::uninitialised(geometry().width, geometry().height)),
        filled_{image_.width, image_.height, -1, -1},
        here_(std::size_t(geometry().regions.count())) {}

  void take(int tile, std::span<const std::byte> bytes) override {
    const PixelRect rect = geometry().regions.rect(tile);
    const std::size_t row_bytes = std::size_t(rect.width()) * 4 * sizeof(float);
    for (int y = 0; y < rect.height(); ++y)
      std::memcpy(image_.pixel(rect.x0, rect.y0 + y), bytes.data() + std::size_t(y) * row_bytes, row_bytes);
    filled_ = {std::min<std::int64_t>(filled_.x0, rect.x0), std::min<std::int64_t>(filled_.y0, rect.y0),
               std::max<std::int64_t>(filled_.x1, rect.x1 - 1),
               std::max<std::int64_t>(filled_.y1, rect.y1 - 1)};
    here_[std::size_t(tile)] = true;
  }

  void finish() override {
    clear_where_no_tile_came();
    const Shown& shown = frame_->shown;
    if (const auto& warp = geometry().warp)
      image_ = warp_image(image_, filled_, *warp, shown.width, shown.height);
    take_(frame_->number, std::move(image_));
  }

 private:
  const FrameGeometry& geometry() const { return frame_->geometry; }

  /// Clears only pixels without a tile, which are few.
  void clear_where_no_tile_came() {
    for (int region = 0; region < geometry().regions.count(); ++region) {
      if (here_[std::size_t(region)]) continue;
      const PixelRect rect = geometry().regions.rect(region);
      for (int y = rect.y0; y < rect.y1; ++y)
        std::fill(image_.pixel(rect.x0, y), image_.pixel(rect.x1, y), 0.0F);
    }
  }

  std::shared_ptr<const SplatFrame> frame_;
  TakePicture take_;
  Image image_;         ///< of the image plane
  PixelWindow filled_;  ///< part of it that tiles have filled
  std::vector<bool> here_;
};

}  // namespace

std::unique_ptr<Canvas> make_picture_canvas(std::shared_ptr<const SplatFrame> frame, TakePicture take) {
  return std::make_unique<PictureCanvas>(std::move(frame), std::move(take));
}

}  // namespace ringsplat

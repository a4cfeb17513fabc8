#include "raster/region_image.hpp"

namespace ringsplat {

float* RegionImage::pixels() {
  if (touched_) return pixels_.get();
  const std::size_t floats = std::size_t(row_floats_) * std::size_t(rect_.height());
  if (!pixels_) pixels_ = allocate_floats(floats);
  std::fill_n(pixels_.get(), floats, 0.0F);
  touched_ = true;
  return pixels_.get();
}

void RegionImage::slices_composited(int slices) {
  // Reading the whole image takes as long as compositing a slice, and news of an opaque tile can wait.
  constexpr int slices_between = 8;
  const int looks = slices_ / slices_between;
  slices_ += slices;
  if (!(opaque_threshold_ > 0 && slices_ / slices_between > looks)) return;
  for (int row = 0; row < tiles_.rows(); ++row)
    for (int column = 0; column < tiles_.columns(); ++column)
      if (!tiles_.is_opaque(column, row) && is_opaque(column, row)) tiles_.set_opaque(column, row);
  tiles_.sum_up();
}

bool RegionImage::is_opaque(int column, int row) const {
  constexpr int size = OpaqueTiles::tile_size;
  const int x_end = std::min((column + 1) * size, rect_.width()),
            y_end = std::min((row + 1) * size, rect_.height());
  for (int y = row * size; y < y_end; ++y) {
    const float* alpha = pixels_.get() + y * row_floats_ + 3;
    for (int x = column * size; x < x_end; ++x)
      if (!(1.0F - alpha[x * floats_a_pixel] < opaque_threshold_)) return false;
  }
  return true;
}

void RegionImage::read_tile(std::span<float> rgba) const {
  const std::size_t row = std::size_t(rect_.width()) * floats_a_pixel;
  if (!touched_) {
    std::fill(rgba.begin(), rgba.end(), 0.0F);
    return;
  }
  for (int y = 0; y < rect_.height(); ++y)
    std::copy_n(pixels_.get() + y * row_floats_, row, rgba.data() + std::size_t(y) * row);
}

}  // namespace ringsplat

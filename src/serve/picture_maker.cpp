#include "serve/picture_maker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "images/image_io.hpp"

namespace ringsplat::serve {
namespace {

/// Where the pixels of a row or column lie in a smaller one.
struct Place {
  int first, second;
  float share;  ///< of the second
};

std::vector<Place> places(int small, int large) {
  std::vector<Place> all;
  for (int k = 0; k < large; ++k) {
    const float at =
        std::clamp((float(k) + 0.5F) * float(small) / float(large) - 0.5F, 0.0F, float(small - 1));
    const int first = static_cast<int>(at);
    all.push_back({first, std::min(first + 1, small - 1), at - float(first)});
  }
  return all;
}

}  // namespace

float rmse_of(const std::vector<std::uint8_t>& small, int small_width, int small_height,
              const std::vector<std::uint8_t>& rgb, int width, int height) {
  const auto columns = places(small_width, width), rows = places(small_height, height);
  const auto at = [&](int x, int y) {
    return &small[3 * (std::size_t(y) * std::size_t(small_width) + std::size_t(x))];
  };
  double sum = 0;
  for (int y = 0; y < height; ++y) {
    const Place& row = rows[std::size_t(y)];
    float in_row = 0;
    for (int x = 0; x < width; ++x) {
      const Place& column = columns[std::size_t(x)];
      const std::uint8_t *a = at(column.first, row.first), *b = at(column.second, row.first),
                         *c = at(column.first, row.second), *d = at(column.second, row.second);
      const std::uint8_t* pixel = &rgb[3 * (std::size_t(y) * std::size_t(width) + std::size_t(x))];
      for (int k = 0; k < 3; ++k) {
        const float above = float(a[k]) + column.share * float(b[k] - a[k]);
        const float below = float(c[k]) + column.share * float(d[k] - c[k]);
        const float error = above + row.share * (below - above) - float(pixel[k]);
        in_row += error * error;
      }
    }
    sum += double(in_row);
  }
  return static_cast<float>(std::sqrt(sum / (3.0 * width * height)));
}

PictureMaker::PictureMaker(int levels)
    : rmse_(std::size_t(levels), std::numeric_limits<float>::quiet_NaN()) {}

std::string PictureMaker::make(RenderedPicture& picture) {
  PictureHead& head = picture.head;
  head.width = picture.image.width;
  head.height = picture.image.height;
  rgb_ = display_rgb(picture.image, picture.background);
  const bool best = head.level + 1 == head.levels;
  head.rmse = best ? 0 : rmse_[std::size_t(head.level)];
  const auto jpeg = encoder_.encode(rgb_, head.width, head.height, picture.quality);
  return picture_message(head, {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
}

void PictureMaker::learn(const RenderedPicture& picture) {
  const PictureHead& head = picture.head;
  if (std::exchange(scene_, picture.scene) != picture.scene) coarse_.clear();
  if (head.level + 1 < head.levels) {
    coarse_.push_back({head.level, head.width, head.height, std::move(rgb_)});
    return;
  }
  for (const Coarse& coarse : coarse_)
    rmse_[std::size_t(coarse.level)] =
        rmse_of(coarse.rgb, coarse.width, coarse.height, rgb_, head.width, head.height);
  coarse_.clear();
}

}  // namespace ringsplat::serve

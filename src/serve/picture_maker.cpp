#include "serve/picture_maker.hpp"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "images/image_io.hpp"
#include "ringsplat/base/error.hpp"

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

std::string picture_message(const PictureHead& head, std::string_view file) {
  std::string message(sizeof head, '\0');
  message += file;
  return with_head(std::move(message), head);
}

std::string with_head(std::string message, const PictureHead& head) {
  std::memcpy(message.data(), &head, sizeof head);
  return message;
}

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
    : encoder_(tjInitCompress(), tjDestroy),
      rmse_(std::size_t(levels), std::numeric_limits<float>::quiet_NaN()) {
  if (!encoder_) throw RunError(fmt::format("no JPEG encoder: {}", tjGetErrorStr2(nullptr)));
}

std::string PictureMaker::make(RenderedPicture& picture) {
  PictureHead& head = picture.head;
  head.width = static_cast<std::uint16_t>(picture.image.width);
  head.height = static_cast<std::uint16_t>(picture.image.height);
  rgb_ = display_bytes(picture.image, picture.background);
  const bool best = head.level + 1 == head.levels;
  head.rmse = best ? 0 : rmse_[std::size_t(head.level)];
  const auto chroma = picture.moving ? TJSAMP_420 : TJSAMP_444;
  unsigned long size = tjBufSize(head.width, head.height, chroma);
  jpeg_.resize(std::max(jpeg_.size(), std::size_t(size)));
  unsigned char* bytes = jpeg_.data();
  if (tjCompress2(encoder_.get(), rgb_.data(), head.width, 0, head.height, TJPF_RGB, &bytes, &size, chroma,
                  picture.moving ? 80 : 95, TJFLAG_NOREALLOC) != 0)
    throw RunError(fmt::format("a picture could not be encoded: {}", tjGetErrorStr2(encoder_.get())));
  return picture_message(head, {reinterpret_cast<const char*>(bytes), size});
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

#pragma once
#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "images/image_io.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/base/image.hpp"

namespace ringsplat::serve {

enum class PictureKind : std::uint32_t { picture = 0, snapshot = 1, movie = 2 };
enum class PictureFormat : std::uint8_t { jpeg = 0, png = 1, exr = 2, mp4 = 3 };

/// What a binary message tells of the file that follows, byte by byte (docs/viewer.md), little endian.
struct PictureHead {
  std::array<char, 4> magic{'R', 'S', 'P', '1'};
  PictureKind kind = PictureKind::picture;
  std::uint32_t number = 0;  ///< to be acknowledged; of a snapshot its id
  std::uint32_t seq = 0;     ///< of the view that it shows
  std::uint16_t width = 0, height = 0;
  std::uint8_t level = 0, levels = 1;
  bool at_rest = false;  ///< nothing finer will come
  PictureFormat format = PictureFormat::jpeg;
  float seconds = 0;  ///< of rendering
  float pictures_a_second = 0;
  double time = 0;                                       ///< of the page's clock, as it was sent
  float rmse = std::numeric_limits<float>::quiet_NaN();  ///< against the best picture, in 1/255
  std::uint32_t pictures = 1;                            ///< of this size, in the file one below the other
};
static_assert(sizeof(PictureHead) == 48);

inline std::string picture_message(const PictureHead& head, std::string_view file) {
  std::string message(reinterpret_cast<const char*>(&head), sizeof head);
  message += file;
  return message;
}

/// A finished frame on its way to the pages.
struct RenderedPicture {
  Image image;
  glm::dvec3 background{0.0};  ///< linear light
  PictureHead head;
  bool moving = true;       ///< less quality will do
  std::uint64_t scene = 0;  ///< the same for pictures of the same view in the same size
};

/// RMSE in 1/255 of a picture, enlarged bilinearly to the size of the other.
inline float rmse_of(const std::vector<std::uint8_t>& small, int small_width, int small_height,
                     const std::vector<std::uint8_t>& rgb, int width, int height) {
  struct Taps {
    int first, second;
    float share;  ///< of the second
  };
  // Where the pixels of a row or column lie in a smaller one.
  const auto taps = [](int few, int many) {
    std::vector<Taps> all;
    for (int k = 0; k < many; ++k) {
      const float at = std::clamp((float(k) + 0.5F) * float(few) / float(many) - 0.5F, 0.0F, float(few - 1));
      const int first = static_cast<int>(at);
      all.push_back({first, std::min(first + 1, few - 1), at - float(first)});
    }
    return all;
  };
  const std::vector<Taps> columns = taps(small_width, width), rows = taps(small_height, height);
  const auto at = [&](int x, int y) {
    return &small[3 * (std::size_t(y) * std::size_t(small_width) + std::size_t(x))];
  };
  double sum = 0;
  for (int y = 0; y < height; ++y) {
    const Taps& row = rows[std::size_t(y)];
    float in_row = 0;
    for (int x = 0; x < width; ++x) {
      const Taps& column = columns[std::size_t(x)];
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

/// Turns frames into messages, and learns what each level errs: whenever a view's best picture comes, its
/// coarser ones are compared with it. For one thread.
class PictureMaker {
 public:
  explicit PictureMaker(int levels)
      : encoder_(tjInitCompress(), tjDestroy),
        rmse_(std::size_t(levels), std::numeric_limits<float>::quiet_NaN()) {
    if (!encoder_) throw RunError(fmt::format("no JPEG encoder: {}", tjGetErrorStr2(nullptr)));
  }
  /// A PNG where the head says so, else a JPEG: of quality 80 with chroma at half size while moving, of 95
  /// with all of it at rest. Fills in the head's size and error. Throws RunError when there is no memory.
  std::string make(RenderedPicture& picture) {
    PictureHead& head = picture.head;
    head.width = static_cast<std::uint16_t>(picture.image.width);
    head.height = static_cast<std::uint16_t>(picture.image.height / int(head.pictures));
    rgb_ = display_bytes(picture.image, picture.background);
    const bool best = head.level + 1 == head.levels;
    head.rmse = best ? 0 : rmse_[std::size_t(head.level)];
    if (head.format == PictureFormat::png) {
      const Bytes png = image_bytes(picture.image, ".png", picture.background, {});
      return picture_message(head, {reinterpret_cast<const char*>(png.data()), png.size()});
    }
    const auto chroma = picture.moving ? TJSAMP_420 : TJSAMP_444;
    unsigned long size = tjBufSize(head.width, picture.image.height, chroma);
    jpeg_.resize(std::max(jpeg_.size(), std::size_t(size)));
    unsigned char* bytes = jpeg_.data();
    if (tjCompress2(encoder_.get(), rgb_.data(), head.width, 0, picture.image.height, TJPF_RGB, &bytes, &size,
                    chroma, picture.moving ? 80 : 95, TJFLAG_NOREALLOC) != 0)
      throw RunError(fmt::format("a picture could not be encoded: {}", tjGetErrorStr2(encoder_.get())));
    return picture_message(head, {reinterpret_cast<const char*>(bytes), size});
  }
  /// Call it after make(), when the message is on its way.
  void learn(const RenderedPicture& picture) {
    const PictureHead& head = picture.head;
    if (std::exchange(scene_, picture.scene) != picture.scene) coarse_.clear();
    if (head.level + 1 < head.levels) {
      coarse_.push_back({head.level, head.width, picture.image.height, std::move(rgb_)});
      return;
    }
    for (const Coarse& coarse : coarse_)
      rmse_[std::size_t(coarse.level)] =
          rmse_of(coarse.rgb, coarse.width, coarse.height, rgb_, head.width, picture.image.height);
    coarse_.clear();
  }

 private:
  struct Coarse {
    int level, width, height;
    std::vector<std::uint8_t> rgb;
  };

  std::unique_ptr<void, int (*)(void*)> encoder_;  ///< libjpeg-turbo's
  std::vector<std::uint8_t> jpeg_;
  std::vector<std::uint8_t> rgb_;  ///< of the last picture made
  std::vector<float> rmse_;        ///< by level
  std::uint64_t scene_ = 0;
  std::vector<Coarse> coarse_;  ///< of that scene
};

}  // namespace ringsplat::serve

#include <cmath>
#include <limits>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "truth/sampling.hpp"

using namespace ringsplat;
using namespace ringsplat::truth;

namespace {

constexpr int size = 200;

/// A smooth picture with structure in both directions; opacity is no less than the colours.
Image picture(double shift_x = 0, double shift_y = 0) {
  Image image(size, size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double u = x - shift_x, v = y - shift_y;
      const double alpha = 0.5 + 0.3 * std::sin(u / 17) * std::cos(v / 23);
      for (int c = 0; c < 4; ++c)
        image.pixel(x, y)[c] =
            static_cast<float>(alpha * (c == 3 ? 1 : 0.5 + 0.2 * std::sin((u + v) / (20 + 5 * c))));
    }
  return image;
}

/// Adds rounding like a renderer's, so that no check passes only because the rest of the error is exactly
/// zero.
Image with_noise(Image image) {
  std::uint32_t state = 1;
  for (auto& v : image.rgba) {
    state = state * 1664525U + 1013904223U;
    v += static_cast<float>((double(state >> 8) / (1 << 24) - 0.5) * 2e-4);
  }
  return image;
}

}  // namespace

TEST_CASE("equal pictures have no error, and a figure for each kind of difference") {
  const Image truth_picture = picture();
  const ImageError none = compare(truth_picture, truth_picture);
  CHECK(none.total.rmse == 0.0);
  CHECK(none.total.largest == 0.0);
  CHECK(none.total.over_1 == 0.0);
  CHECK(std::isinf(none.total.psnr()));

  Image brighter = truth_picture;
  for (int p = 0; p < size * size; ++p) brighter.rgba[std::size_t(4 * p + 1)] += 1.5F / 255;
  const ImageError error = compare(brighter, truth_picture);
  CHECK(error.channels[1].mean == Approx(1.5).epsilon(1e-4));
  CHECK(error.channels[1].rmse == Approx(1.5).epsilon(1e-4));
  CHECK(error.channels[0].rmse == 0.0);
  CHECK(error.total.rmse == Approx(0.75).epsilon(1e-4));
  CHECK(error.total.mean == Approx(0.375).epsilon(1e-4));
  CHECK(error.total.over_1 == 1.0);
  CHECK(error.channels[0].over_1 == 0.0);
  CHECK(error.total.over_2 == 0.0);
  CHECK(error.channels[1].psnr() == Approx(20 * std::log10(255 / 1.5)).epsilon(1e-4));
}

TEST_CASE("a value that is not finite is infinitely wrong") {
  const Image truth_picture = picture();
  Image broken = truth_picture;
  broken.pixel(7, 9)[2] = std::numeric_limits<float>::quiet_NaN();
  CHECK(std::isinf(compare(broken, truth_picture).total.largest));
  CHECK(std::isinf(compare(broken, truth_picture).total.rmse));
  CHECK(compare(broken, truth_picture).total.over_2 == Approx(1.0 / (size * size)));
  CHECK(compare(broken, truth_picture).worst == Pixel{7, 9});
  Image also_broken = truth_picture;
  also_broken.pixel(7, 9)[2] = std::numeric_limits<float>::quiet_NaN();
  CHECK(compare(broken, also_broken).total.rmse == 0.0);
}

TEST_CASE("8-bit pictures one level apart are not over one level") {
  Image dark(256, 1), bright(256, 1);
  for (int level = 0; level < 255; ++level) {
    dark.pixel(level, 0)[0] = static_cast<float>(level) / 255;
    bright.pixel(level, 0)[0] = static_cast<float>(level + 1) / 255;
  }
  CHECK(compare(bright, dark).total.over_1 == 0.0);
  CHECK(compare(bright, dark, 4, 0.999).over_threshold == Approx(255.0 / 256));
}

TEST_CASE("of opaque pictures the fourth channel is left out") {
  const Image truth_picture = picture();
  Image other = truth_picture;
  for (std::size_t at = 0; at < other.rgba.size(); at += 4) {
    other.rgba[at] += 3.0F / 255;
    other.rgba[at + 3] = 0;
  }
  const ImageError error = compare(other, truth_picture, 3);
  CHECK(error.total.rmse == Approx(3 / std::sqrt(3.0)).epsilon(1e-4));
  CHECK(error.total.mean == Approx(1).epsilon(1e-4));
  CHECK(error.channels[3].largest == 0.0);
  CHECK(compare(other, truth_picture, 3, 2.9).over_threshold == 1.0);
  CHECK(compare(other, truth_picture, 3, 3.1).over_threshold == 0.0);
  CHECK(compare(other, truth_picture, 4, 3.1).over_threshold == 1.0);
}

TEST_CASE("planted: 3/255 in one pixel in a thousand is found") {
  const Image truth_picture = picture();
  Image planted = with_noise(truth_picture);
  for (int p = 0; p < size * size; p += 1000) planted.rgba[std::size_t(4 * p)] += 3.0F / 255;
  const ImageError error = compare(planted, truth_picture);
  CHECK(error.total.over_1 == Approx(0.001));
  CHECK(error.total.over_2 == Approx(0.001));
  CHECK(error.total.largest == Approx(3).epsilon(0.02));
  CHECK(error.worst.x % 200 == 0);
  CHECK(compare(planted, truth_picture, 4, 2.5).over_threshold == Approx(0.001));
  CHECK(error.channels[0].over_2 == Approx(0.001));
  CHECK(error.channels[1].over_1 == 0.0);
  const ImageError before = compare(with_noise(truth_picture), truth_picture);
  CHECK(before.total.over_1 == 0.0);
  CHECK(error.total.rmse > 2 * before.total.rmse);  // 0.047 beside noise of 0.015
}

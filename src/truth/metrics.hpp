#pragma once
#include <array>
#include <cmath>
#include <limits>

#include "ringsplat/base/image.hpp"
#include "truth/scene.hpp"

namespace ringsplat::truth {

/// Levels of an 8-bit picture. All differences are in units of one level.
constexpr double levels = 255;

/// a − b in levels. A value that is not finite is infinitely far from every other value.
inline double levels_apart(double a, double b) {
  if (std::isfinite(a) && std::isfinite(b)) return levels * (a - b);
  const bool same = a == b || (std::isnan(a) && std::isnan(b));
  return same ? 0.0 : std::numeric_limits<double>::infinity();
}

/// Differences image − truth of premultiplied linear values, in units of 1/255.
struct ErrorFigures {
  double rmse = 0;
  double largest = 0;   ///< absolute
  double mean = 0;      ///< signed: above zero when the image is brighter
  double over_1 = 0;    ///< fraction of the pixels that differ by more than 1/255
  double over_2 = 0;    ///< and by more than 2/255
  double psnr() const;  ///< dB against a peak of 1; infinite for equal pictures
};

struct ImageError {
  ErrorFigures total;                    ///< a pixel counts as over when one of its channels is
  std::array<ErrorFigures, 4> channels;  ///< red, green, blue, opacity
  Pixel worst{0, 0};                     ///< where `total.largest` is
  double over_threshold = 0;             ///< fraction of the pixels that differ by more than threshold / 255
};

/// Of two pictures of one size. A value that is not finite counts as infinitely wrong, unless it is the same
/// in both. `channels` is 4, or 3 for pictures without a meaningful opacity: figures then leave opacity out,
/// and its own are zero.
ImageError compare(const Image& image, const Image& truth, int channels = 4, double threshold = 1);

}  // namespace ringsplat::truth

#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "ringsplat/base/image.hpp"

namespace ringsplat::app {

/// How much two pictures differ. Differences are a − b in units of 1/255.
struct Difference {
  double rmse = 0;      ///< root of the mean square
  double largest = 0;   ///< largest absolute difference
  double mean = 0;      ///< signed: above zero when a is brighter
  double psnr() const;  ///< dB against a peak of 1; infinite for equal pictures
};

struct ImageDifference {
  Difference total;
  std::array<Difference, 4> channels;  ///< red, green, blue, alpha
  int channel_count = 4;             ///< 3: neither picture has alpha, which is then left out of all figures
  int largest_x = 0, largest_y = 0;  ///< pixel of the largest difference
  std::uint64_t pixels = 0, pixels_over = 0;
  double fraction_over() const { return pixels == 0 ? 0 : double(pixels_over) / double(pixels); }
};

/// Both of the same size. A value that is not finite in one picture and not the same in the other counts as
/// an infinite difference. `threshold` in 1/255: a pixel is over it when one of its channels is.
ImageDifference difference(const Image& a, const Image& b, int channels, double threshold);

/// a − b per channel times `scale` (signed), alpha 1; absolute values when `absolute`.
Image difference_image(const Image& a, const Image& b, double scale, bool absolute);

}  // namespace ringsplat::app

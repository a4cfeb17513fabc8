#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "truth/scene.hpp"

namespace ringsplat::truth {

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
};

/// Throws InputError when the sizes differ. A value that is not finite counts as infinitely wrong, unless it
/// is the same in both. `channels` is 4, or 3 for pictures without a meaningful opacity: figures then leave
/// opacity out, and its own are zero.
ImageError compare(const Image& image, const Image& truth, int channels = 4);

/// The fraction of the pixels that differ by more than `threshold` / 255 in one of the first `channels`
/// channels. The pictures must have the same size.
double fraction_over(const Image& image, const Image& truth, double threshold, int channels = 4);

/// Measures of defects that a single figure hides. All treat opacities and colours alike.

/// A row or column whose mean signed error stands out from the two lines beside it.
struct Seam {
  bool is_column = true;
  int position = 0;
  double step = 0;  ///< in 1/255, above both neighbours (or below both)
  double odds = 0;  ///< step divided by the typical step (1.4826 × median) of all lines of that direction
};
/// The most conspicuous line; nothing when the picture has fewer than eight lines each way.
std::optional<Seam> find_seam(const Image& image, const Image& truth);

/// The gain g for which image = (1 + g) truth fits best (least squares); 0 for an empty truth.
double brightness_change(const Image& image, const Image& truth);

/// The displacement in pixels (right, down) by which the shifted truth fits the image best (Lucas and Kanade
/// 1981, iterated on the resampled truth). Zero where the truth has no structure.
struct Shift {
  double x = 0, y = 0;
};
Shift find_shift(const Image& image, const Image& truth);

}  // namespace ringsplat::truth

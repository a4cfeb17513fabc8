#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "truth/scene.hpp"

namespace ringsplat::truth {

/// The pixels at which to evaluate a truth: a stratified random sample (Cochran 1977, chapter 5) of those
/// that the volume may reach. At all others the truth is transparent.
struct PixelSample {
  struct Stratum {
    std::size_t pixels = 0;   ///< that belong to it
    std::size_t sampled = 0;  ///< of them sampled: all, or at least two if the sample is large enough
  };
  ScreenBounds bounds;
  std::vector<Stratum> strata;
  std::vector<Pixel> pixels;  ///< stratum after stratum, row by row in each
};

/// Draws at most `count` pixels within `bounds`, without repetition; all of them when there are no more. A
/// stratum has pixels with about the same local variation in `picture`; opaque pixels have strata of their
/// own. Edges and silhouettes err most and are sampled most densely, but every pixel may be drawn. Any
/// picture of the scene will do, so that one sample can serve several pictures that are compared. The same
/// picture bits and seed give the same sample on every machine.
PixelSample draw_sample(const Image& picture, const ScreenBounds& bounds, std::size_t count,
                        std::uint64_t seed);

/// The whole picture's error, estimated from a sample. Differences as in ErrorFigures.
struct SampledError {
  std::size_t pixels = 0;              ///< at which the truth was evaluated
  std::size_t outside = 0;             ///< where the truth is transparent; all of these were compared, too
  double rmse = 0;                     ///< of the whole picture, over four channels, in 1/255
  double rmse_low = 0, rmse_high = 0;  ///< its 95 % confidence interval
  double largest = 0;                  ///< of the pixels compared, in 1/255
  double mean = 0;                     ///< of the whole picture, signed
  Pixel worst{0, 0};                   ///< where `largest` is
};

/// `truth[k]` belongs to `sample.pixels[k]`; the image has the size of the one the sample was drawn from. The
/// mean square and the mean are unbiased. The interval is Student's of the mean square's logarithm, with the
/// strata's finite populations and Satterthwaite's degrees of freedom. Since a few pixels may have most of
/// the error, each stratum's variance is computed as if more pixels as bad as its worst had been drawn. From
/// about a thousand pixels on the interval holds the true RMSE as often as it claims (docs/accuracy.md). It
/// cannot cover an error in a few pixels that shows neither in the picture nor in the sample. A value of the
/// picture that is not finite makes its RMSE infinite, sampled or not.
/// `by_pixel` gets each pixel's largest difference, row by row; not a number where it is not known.
SampledError sampled_error(const Image& image, const PixelSample& sample, std::span<const Rgba> truth,
                           std::vector<float>* by_pixel = nullptr);

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
  double largest = 0;  ///< absolute
  double mean = 0;     ///< signed: above zero when the image is brighter
  double over_1 = 0;   ///< fraction of the pixels that differ by more than 1/255
  double over_2 = 0;   ///< and by more than 2/255
  /// dB against a peak of 1; infinite for equal pictures.
  double psnr() const { return 20 * std::log10(levels / rmse); }
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

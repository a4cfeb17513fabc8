#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "ringsplat/truth/scene.hpp"

namespace ringsplat::truth {

/// Pixels of a picture at which a truth is to be evaluated: a stratified random sample (Cochran 1977, chapter
/// 5) of those that the volume may reach. At all others the truth is transparent.
struct PixelSample {
  struct Stratum {
    std::size_t pixels = 0;   ///< that belong to it
    std::size_t sampled = 0;  ///< of them; all of them, or at least two where two can be afforded
  };
  ScreenBounds bounds;
  std::vector<Stratum> strata;
  std::vector<Pixel> pixels;  ///< stratum after stratum, row by row in each
};

/// At most `count` pixels within `bounds`, drawn without repetition; all of them when there are no more.
/// Strata are made of pixels about which `picture` differs alike, and apart from those of opaque pixels:
/// edges and silhouettes err most and are sampled most densely, but no pixel is left out for sure. Any
/// picture of the scene will do, so that one sample may serve pictures that are to be compared. The same
/// sample for the same bits of the picture and the same seed, on every machine.
PixelSample draw_sample(const Image& picture, const ScreenBounds& bounds, std::size_t count,
                        std::uint64_t seed);

/// What a sample says of the error of the whole picture. Differences as in ErrorFigures.
struct SampledError {
  std::size_t pixels = 0;              ///< at which the truth was evaluated
  std::size_t outside = 0;             ///< and those where it is transparent; all of them were compared, too
  double rmse = 0;                     ///< of the whole picture, over four channels, in 1/255
  double rmse_low = 0, rmse_high = 0;  ///< its 95 % confidence interval
  double largest = 0;                  ///< of the pixels compared, in 1/255
  double mean = 0;                     ///< of the whole picture, signed
  Pixel worst{0, 0};                   ///< where `largest` is
};

/// `truth[k]` belongs to `sample.pixels[k]`; the image has the size of the one the sample was drawn from. The
/// mean square and the mean are unbiased. The interval is Student's of the mean square's logarithm, with the
/// strata's finite populations and Satterthwaite's degrees of freedom. Since a few pixels may have most of
/// the error, each stratum's variance is taken as if more pixels as bad as its worst had been met. It holds
/// the true RMSE as often as it says from about a thousand pixels on (docs/accuracy.md); an error in a few
/// pixels of which neither the picture nor the sample shows a sign is beyond it. A value of the picture that
/// is not finite makes its RMSE infinite, sampled or not. Throws InputError when there is no picture, or not
/// one colour for each pixel.
SampledError sampled_error(const Image& image, const PixelSample& sample, std::span<const Rgba> truth);

}  // namespace ringsplat::truth

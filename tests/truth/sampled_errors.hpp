#pragma once
#include "truth_support.hpp"

namespace ringsplat::test {

/// Roots of the mean squared differences from the truths at some pixels, in 1/255.
struct SampledErrors {
  std::vector<truth::Pixel> pixels;
  std::vector<truth::Rgba> exact;

  double of(const Image& picture) const {
    double sum = 0;
    for (std::size_t k = 0; k < pixels.size(); ++k)
      for (int c = 0; c < 4; ++c)
        sum += std::pow(255 * (picture.pixel(pixels[k].x, pixels[k].y)[c] - exact[k][c]), 2);
    return std::sqrt(sum / (4.0 * double(pixels.size())));
  }
};

inline SampledErrors from_field(const Volume& volume, const FrameSpec& spec, std::size_t count) {
  const auto pixels = random_pixels(spec.shown.width, spec.shown.height, count, 5);
  return {pixels, truth::field_truth(scene_of(volume, spec), pixels)};
}
inline SampledErrors from_method(const Volume& volume, const FrameSpec& spec, std::size_t count) {
  const auto pixels = random_pixels(spec.shown.width, spec.shown.height, count, 5);
  return {pixels, truth::method_truth(scene_of(volume, spec), pixels)};
}

}  // namespace ringsplat::test

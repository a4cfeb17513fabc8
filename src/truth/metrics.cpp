#include "ringsplat/truth/metrics.hpp"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ringsplat/base/error.hpp"

namespace ringsplat::truth {
namespace {

constexpr double levels = 255;

double apart(double a, double b) {
  if (std::isfinite(a) && std::isfinite(b)) return levels * (a - b);
  const bool same = a == b || (std::isnan(a) && std::isnan(b));
  return same ? 0.0 : std::numeric_limits<double>::infinity();
}

struct Sums {
  double squares = 0, signed_sum = 0, largest = 0;
  void add(double d) {
    squares += d * d;
    signed_sum += d;
    largest = std::max(largest, std::abs(d));
  }
};

ErrorFigures figures(const Sums& sums, double values) {
  ErrorFigures f;
  f.rmse = std::sqrt(sums.squares / values);
  f.largest = sums.largest;
  f.mean = sums.signed_sum / values;
  return f;
}

OIIO::ImageBuf buffer(const Image& image) {
  return {OIIO::ImageSpec(image.width, image.height, 4, OIIO::TypeDesc::FLOAT),
          const_cast<float*>(image.rgba.data())};
}

/// Counts the pixels of which a channel of [first, end) is over one or two levels, by OpenImageIO, whose own
/// sums of squares are not used: they are rounded to float32.
void count_over(const Image& image, const Image& truth, int first, int end, ErrorFigures& f, Pixel* worst) {
  const OIIO::ROI roi(0, image.width, 0, image.height, 0, 1, first, end);
  const auto found = OIIO::ImageBufAlgo::compare(buffer(image), buffer(truth), static_cast<float>(2 / levels),
                                                 static_cast<float>(1 / levels), roi);
  const double pixels = double(image.width) * image.height;
  f.over_1 = double(found.nwarn) / pixels;
  f.over_2 = double(found.nfail) / pixels;
  if (worst != nullptr) *worst = {found.maxx, found.maxy};
}

}  // namespace

double ErrorFigures::psnr() const { return 20 * std::log10(levels / rmse); }

ImageError compare(const Image& image, const Image& truth) {
  if (image.width != truth.width || image.height != truth.height || image.width < 1 || image.height < 1)
    throw InputError(fmt::format("pictures of {}x{} and {}x{} pixels cannot be compared", image.width,
                                 image.height, truth.width, truth.height),
                     "compare pictures of the same size");
  std::array<Sums, 4> by_channel;
  Sums all;
  for (std::size_t at = 0; at < image.rgba.size(); ++at) {
    const double d = apart(double(image.rgba[at]), double(truth.rgba[at]));
    by_channel[at % 4].add(d);
    all.add(d);
  }
  ImageError error;
  const double pixels = double(image.width) * image.height;
  error.total = figures(all, 4 * pixels);
  count_over(image, truth, 0, 4, error.total, &error.worst);
  for (int c = 0; c < 4; ++c) {
    error.channels[std::size_t(c)] = figures(by_channel[std::size_t(c)], pixels);
    count_over(image, truth, c, c + 1, error.channels[std::size_t(c)], nullptr);
  }
  return error;
}

SampledError sampled_error(const Image& image, std::span<const Pixel> pixels, std::span<const Rgba> truth) {
  if (pixels.size() != truth.size() || pixels.empty())
    throw InputError(
        fmt::format("{} pixels cannot be compared with {} true colours", pixels.size(), truth.size()),
        "sample at least one pixel");
  SampledError error;
  error.pixels = pixels.size();
  Sums sums;
  double fourth_powers = 0;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const float* pixel = image.pixel(pixels[p].x, pixels[p].y);
    double square = 0;
    for (int c = 0; c < 4; ++c) {
      const double d = apart(double(pixel[c]), truth[p][c]);
      if (std::abs(d) > sums.largest) error.worst = pixels[p];
      sums.add(d);
      square += d * d / 4;
    }
    fourth_powers += square * square;
  }
  const auto count = double(pixels.size()), total = double(image.width) * image.height;
  const ErrorFigures f = figures(sums, 4 * count);
  error.rmse = f.rmse;
  error.largest = f.largest;
  error.mean = f.mean;
  const double mean_square = f.rmse * f.rmse;
  const double variance =
      count > 1 ? std::max(0.0, fourth_powers / count - mean_square * mean_square) * count / (count - 1)
                : 0.0;
  const double not_sampled = total > 1 ? std::max(0.0, (total - count) / (total - 1)) : 0.0;
  constexpr double normal_95 = 1.959964;
  const double margin = normal_95 * std::sqrt(variance / count * not_sampled);
  error.rmse_low = std::sqrt(std::max(0.0, mean_square - margin));
  error.rmse_high = std::sqrt(mean_square + margin);
  return error;
}

}  // namespace ringsplat::truth

#include "ringsplat/truth/metrics.hpp"

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

/// How far apart the pixels are in the channels [first, end), the most of them each. OpenImageIO's comparison
/// is not used: it leaves pixels that are not finite out of its counts, and sums squares in float32.
class PixelDistances {
 public:
  PixelDistances(const Image& image, const Image& truth, int first, int end) : width_(image.width) {
    for (std::size_t at = 0; at < image.rgba.size(); at += 4) {
      double most = 0;
      for (auto c = std::size_t(first); c < std::size_t(end); ++c)
        most = std::max(most, std::abs(apart(double(image.rgba[at + c]), double(truth.rgba[at + c]))));
      distances_.push_back(most);
    }
  }
  /// The limit is widened by its ten-thousandth: values of 8 bits that lie a whole number of levels apart do
  /// so only up to float32's rounding, and must not be over it by chance.
  double fraction_over(double limit) const {
    const auto over = [&](double d) { return d > limit * 1.0001; };
    return double(std::count_if(distances_.begin(), distances_.end(), over)) / double(distances_.size());
  }
  Pixel worst() const {
    const auto at = int(std::max_element(distances_.begin(), distances_.end()) - distances_.begin());
    return {at % width_, at / width_};
  }

 private:
  int width_;
  std::vector<double> distances_;
};

}  // namespace

double ErrorFigures::psnr() const { return 20 * std::log10(levels / rmse); }

ImageError compare(const Image& image, const Image& truth, int channels) {
  if (image.width != truth.width || image.height != truth.height || image.width < 1 || image.height < 1)
    throw InputError(fmt::format("pictures of {}x{} and {}x{} pixels cannot be compared", image.width,
                                 image.height, truth.width, truth.height),
                     "compare pictures of the same size");
  std::array<Sums, 4> by_channel;
  Sums all;
  for (std::size_t at = 0; at < image.rgba.size(); ++at)
    if (const auto channel = at % 4; int(channel) < channels) {
      const double d = apart(double(image.rgba[at]), double(truth.rgba[at]));
      by_channel[channel].add(d);
      all.add(d);
    }
  ImageError error;
  const double pixels = double(image.width) * image.height;
  error.total = figures(all, channels * pixels);
  const auto set_fractions = [](ErrorFigures& f, const PixelDistances& distances) {
    f.over_1 = distances.fraction_over(1);
    f.over_2 = distances.fraction_over(2);
  };
  const PixelDistances distances(image, truth, 0, channels);
  set_fractions(error.total, distances);
  error.worst = distances.worst();
  for (int c = 0; c < channels; ++c) {
    ErrorFigures& f = error.channels[std::size_t(c)];
    f = figures(by_channel[std::size_t(c)], pixels);
    set_fractions(f, PixelDistances(image, truth, c, c + 1));
  }
  return error;
}

double fraction_over(const Image& image, const Image& truth, double threshold, int channels) {
  return PixelDistances(image, truth, 0, channels).fraction_over(threshold);
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

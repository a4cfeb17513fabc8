// Estimates the whole picture's error from a stratified sample.
#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "truth/sampling.hpp"

namespace ringsplat::truth {
namespace {

/// A pixel's difference, over the four channels.
struct Difference {
  double square = 0, mean = 0, largest = 0;
};

/// The sampled squares of a stratum.
struct Squares {
  PixelSample::Stratum stratum;
  std::span<const double> values;
  double mean = 0, largest = 0;

  bool complete() const { return stratum.sampled == stratum.pixels; }
  double total() const { return double(stratum.pixels) * mean; }

  /// The variance of total(), as if its largest square had been drawn once more, and the larger of it and
  /// `other` as well. A stratum's rare large squares are seldom in its sample; without them it would seem to
  /// have none.
  double variance(double other) const {
    const auto pixels = double(stratum.pixels), sampled = double(stratum.sampled);
    const double left_out = pixels * (pixels - sampled) / sampled;
    if (values.size() == 1) return left_out * largest * largest;  // a single value shows no spread
    const std::array further{largest, std::max(largest, other)};
    const double count = double(values.size() + further.size());
    const double middle = (double(values.size()) * mean + further[0] + further[1]) / count;
    double sum = 0;
    for (const double v : values) sum += (v - middle) * (v - middle);
    for (const double v : further) sum += (v - middle) * (v - middle);
    return left_out * sum / (count - 1);
  }
};

/// 95 % interval of the picture's sum of squares: `sum` is its estimate, of which `known` is exact.
std::pair<double, double> interval_of(const std::vector<Squares>& strata, double sum, double known) {
  double variance = 0, satterthwaite = 0;
  for (std::size_t k = 0; k < strata.size(); ++k) {
    const Squares& s = strata[k];
    if (s.complete()) {
      known += s.total();
      continue;
    }
    // Half of the neighbours' worst square: strata merge gradually, so a stratum may hold such pixels.
    const double before = k > 0 ? strata[k - 1].largest : 0,
                 behind = k + 1 < strata.size() ? strata[k + 1].largest : 0,
                 v = s.variance(0.5 * std::max(before, behind));
    variance += v;
    satterthwaite += v * v / std::max(1.0, double(s.stratum.sampled) - 1);
  }
  if (!std::isfinite(sum) || !(variance > 0 && sum > 0)) return {sum, sum};
  const double freedom = std::min(std::max(1.0, variance * variance / satterthwaite), 1e9);
  const double t = boost::math::quantile(boost::math::students_t(freedom), 0.975);
  const double factor = std::exp(t * std::sqrt(variance) / sum);
  return {std::max(known, sum / factor), sum * factor};
}

/// Widens the limit by a ten-thousandth: 8-bit values that are a whole number of levels apart are so only up
/// to float32's rounding, and must not exceed the limit by chance.
double fraction_over(double limit, const std::vector<double>& differences) {
  const auto over = [&](double d) { return d > limit * 1.0001; };
  return double(std::ranges::count_if(differences, over)) / double(differences.size());
}

/// What two pictures differ by, over the channels [first, end), and in each pixel at most. OpenImageIO's
/// comparison is not used: it does not count pixels that are not finite, and it sums squares in float32.
ErrorFigures figures_of(const Image& image, const Image& truth, int first, int end,
                        std::vector<double>& largest) {
  double squares = 0, sum = 0;
  largest.clear();
  for (std::size_t at = 0; at < image.rgba.size(); at += 4) {
    double& most = largest.emplace_back(0);
    for (auto c = std::size_t(first); c < std::size_t(end); ++c) {
      const double d = levels_apart(double(image.rgba[at + c]), double(truth.rgba[at + c]));
      squares += d * d;
      sum += d;
      most = std::max(most, std::abs(d));
    }
  }
  const double values = (end - first) * double(largest.size());
  return {std::sqrt(squares / values), *std::ranges::max_element(largest), sum / values,
          fraction_over(1, largest), fraction_over(2, largest)};
}

}  // namespace

SampledError sampled_error(const Image& image, const PixelSample& sample, std::span<const Rgba> truth,
                           std::vector<float>* by_pixel) {
  SampledError error{.pixels = truth.size()};
  if (by_pixel != nullptr) by_pixel->assign(image.rgba.size() / 4, std::numeric_limits<float>::quiet_NaN());
  double known = 0, signed_sum = 0;
  const auto see = [&](Pixel at, const Rgba& colour) {
    Difference d;
    for (int c = 0; c < 4; ++c) {
      const double apart = levels_apart(double(image.pixel(at.x, at.y)[c]), colour[c]);
      d.square += apart * apart / 4;
      d.mean += apart / 4;
      d.largest = std::max(d.largest, std::abs(apart));
    }
    if (d.largest > error.largest) error.worst = at;
    error.largest = std::max(error.largest, d.largest);
    if (by_pixel != nullptr) (*by_pixel)[std::size_t(at.y * image.width + at.x)] = float(d.largest);
    return d;
  };
  // The pixels whose error is known without the truth: where it is transparent, and where the picture is not
  // finite.
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const bool inside = sample.bounds.rows[std::size_t(y)].contains(x);
      const std::span pixel(image.pixel(x, y), 4);
      if (inside && std::ranges::all_of(pixel, [](float v) { return std::isfinite(v); })) continue;
      const Difference d = see({x, y}, Rgba(0.0));
      known += d.square;
      signed_sum += d.mean;
      if (!inside) ++error.outside;
    }
  std::vector<double> values;  // of all strata, which point into it
  values.reserve(truth.size());
  std::vector<Squares> strata;
  for (const auto& stratum : sample.strata) {
    Squares s{stratum, {}};
    double means = 0;
    for (std::size_t k = 0; k < stratum.sampled; ++k) {
      const Difference d = see(sample.pixels[values.size()], truth[values.size()]);
      values.push_back(d.square);
      s.mean += d.square / double(stratum.sampled);
      s.largest = std::max(s.largest, d.square);
      means += d.mean / double(stratum.sampled);
    }
    s.values = std::span(values).last(stratum.sampled);
    signed_sum += means * double(stratum.pixels);
    strata.push_back(s);
  }
  double sum = known;
  for (const Squares& s : strata) sum += s.total();
  const auto [low, high] = interval_of(strata, sum, known);
  const double pixels = double(image.width) * image.height;
  error.mean = signed_sum / pixels;
  error.rmse = std::sqrt(sum / pixels);
  error.rmse_low = std::sqrt(low / pixels);
  error.rmse_high = std::sqrt(high / pixels);
  return error;
}

ImageError compare(const Image& image, const Image& truth, int channels, double threshold) {
  std::vector<double> largest;
  ImageError error;
  for (int c = 0; c < channels; ++c)
    error.channels[std::size_t(c)] = figures_of(image, truth, c, c + 1, largest);
  error.total = figures_of(image, truth, 0, channels, largest);
  const auto worst = int(std::ranges::max_element(largest) - largest.begin());
  error.worst = {worst % image.width, worst / image.width};
  error.over_threshold = fraction_over(threshold, largest);
  return error;
}

}  // namespace ringsplat::truth

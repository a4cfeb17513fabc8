#include "truth/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ringsplat/base/error.hpp"
#include "truth/levels.hpp"

namespace ringsplat::truth {
namespace {

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

/// Each pixel's largest difference over the channels [first, end). OpenImageIO's comparison is not used: it
/// does not count pixels that are not finite, and it sums squares in float32.
class PixelDistances {
 public:
  PixelDistances(const Image& image, const Image& truth, int first, int end) : width_(image.width) {
    for (std::size_t at = 0; at < image.rgba.size(); at += 4) {
      double most = 0;
      for (auto c = std::size_t(first); c < std::size_t(end); ++c)
        most = std::max(most, std::abs(levels_apart(double(image.rgba[at + c]), double(truth.rgba[at + c]))));
      distances_.push_back(most);
    }
  }
  /// Widens the limit by a ten-thousandth: 8-bit values that are a whole number of levels apart are so only
  /// up to float32's rounding, and must not exceed the limit by chance.
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
      const double d = levels_apart(double(image.rgba[at]), double(truth.rgba[at]));
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

}  // namespace ringsplat::truth

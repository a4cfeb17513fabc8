#include "truth/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ringsplat::truth {
namespace {

/// What two pictures differ by, over the channels [first, end). OpenImageIO's comparison is not used: it does
/// not count pixels that are not finite, and it sums squares in float32.
class Differences {
 public:
  Differences(const Image& image, const Image& truth, int first, int end)
      : width_(image.width), channels_(end - first) {
    for (std::size_t at = 0; at < image.rgba.size(); at += 4) {
      double most = 0;
      for (auto c = std::size_t(first); c < std::size_t(end); ++c) {
        const double d = levels_apart(double(image.rgba[at + c]), double(truth.rgba[at + c]));
        squares_ += d * d;
        sum_ += d;
        most = std::max(most, std::abs(d));
      }
      largest_.push_back(most);
    }
  }
  ErrorFigures figures() const {
    const double values = channels_ * double(largest_.size());
    return {std::sqrt(squares_ / values), *std::max_element(largest_.begin(), largest_.end()), sum_ / values,
            fraction_over(1), fraction_over(2)};
  }
  /// Widens the limit by a ten-thousandth: 8-bit values that are a whole number of levels apart are so only
  /// up to float32's rounding, and must not exceed the limit by chance.
  double fraction_over(double limit) const {
    const auto over = [&](double d) { return d > limit * 1.0001; };
    return double(std::count_if(largest_.begin(), largest_.end(), over)) / double(largest_.size());
  }
  Pixel worst() const {
    const auto at = int(std::max_element(largest_.begin(), largest_.end()) - largest_.begin());
    return {at % width_, at / width_};
  }

 private:
  int width_, channels_;
  double squares_ = 0, sum_ = 0;
  std::vector<double> largest_;  ///< of each pixel
};

}  // namespace

double ErrorFigures::psnr() const { return 20 * std::log10(levels / rmse); }

ImageError compare(const Image& image, const Image& truth, int channels, double threshold) {
  const Differences all(image, truth, 0, channels);
  ImageError error{all.figures(), {}, all.worst(), all.fraction_over(threshold)};
  for (int c = 0; c < channels; ++c)
    error.channels[std::size_t(c)] = Differences(image, truth, c, c + 1).figures();
  return error;
}

}  // namespace ringsplat::truth

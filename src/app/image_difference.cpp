#include "app/image_difference.hpp"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ringsplat::app {
namespace {

double apart(float a, float b) {
  if (std::isfinite(a) && std::isfinite(b)) return 255.0 * (double(a) - double(b));
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
  Difference over(double count) const { return {std::sqrt(squares / count), largest, signed_sum / count}; }
};

OIIO::ImageBuf buffer(const Image& image) {
  return {OIIO::ImageSpec(image.width, image.height, 4, OIIO::TypeDesc::FLOAT),
          const_cast<float*>(image.rgba.data())};
}

}  // namespace

double Difference::psnr() const { return 20 * std::log10(255.0 / rmse); }

ImageDifference difference(const Image& a, const Image& b, int channels, double threshold) {
  ImageDifference result;
  result.channel_count = channels;
  result.pixels = std::uint64_t(a.width) * std::uint64_t(a.height);
  std::array<Sums, 4> by_channel;
  Sums all;
  for (std::size_t at = 0; at < a.rgba.size(); ++at)
    if (const auto channel = at % 4; int(channel) < channels) {
      const double d = apart(a.rgba[at], b.rgba[at]);
      by_channel[channel].add(d);
      all.add(d);
    }
  result.total = all.over(double(result.pixels) * channels);
  for (std::size_t c = 0; c < std::size_t(channels); ++c)
    result.channels[c] = by_channel[c].over(double(result.pixels));

  // OpenImageIO counts the pixels and finds the worst; its sums are float32-rounded, hence our own above.
  const OIIO::ROI roi(0, a.width, 0, a.height, 0, 1, 0, channels);
  const auto limit = static_cast<float>(threshold / 255.0);
  const auto found = OIIO::ImageBufAlgo::compare(buffer(a), buffer(b), limit, limit, roi);
  result.largest_x = found.maxx;
  result.largest_y = found.maxy;
  result.pixels_over = found.nfail;
  return result;
}

Image difference_image(const Image& a, const Image& b, double scale, bool absolute) {
  Image out(a.width, a.height);
  for (std::size_t at = 0; at < out.rgba.size(); ++at) {
    const auto d = static_cast<float>(scale * (double(a.rgba[at]) - double(b.rgba[at])));
    out.rgba[at] = at % 4 == 3 ? 1.0F : absolute ? std::abs(d) : d;
  }
  return out;
}

}  // namespace ringsplat::app

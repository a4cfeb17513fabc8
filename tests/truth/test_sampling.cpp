#include <algorithm>
#include <limits>
#include <set>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "truth/sampling.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;
using namespace ringsplat::truth;

namespace {

constexpr int width = 90, height = 70;

/// A disc with a soft edge and a hard bar across it. Values are whole 256ths, the same bits on every machine.
Image picture() {
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int square = (x - 45) * (x - 45) + (y - 35) * (y - 35);
      const int level = y / 4 == 8 ? 256 : std::clamp((900 - square) / 2, 0, 256);
      for (int c = 0; c < 4; ++c) image.pixel(x, y)[c] = static_cast<float>(level * (c + 1) / 4) / 256;
    }
  return image;
}

/// All of the picture but a margin.
ScreenBounds bounds(int margin = 8) {
  ScreenBounds b;
  b.rows.resize(height);
  for (int y = margin; y < height - margin; ++y) b.rows[std::size_t(y)] = {margin, width - margin};
  return b;
}

std::vector<Rgba> nothing(const PixelSample& sample) {
  return std::vector<Rgba>(sample.pixels.size(), Rgba(0.0));
}

void check_bounds(const Image& truth, const ScreenBounds& bounds) {
  REQUIRE(bounds.rows.size() == std::size_t(truth.height));
  int shown = 0;
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x) {
      const bool seen = std::any_of(truth.pixel(x, y), truth.pixel(x, y) + 4, [](float v) { return v != 0; });
      shown += seen;
      if (seen) CHECK(bounds.rows[std::size_t(y)].contains(x));
    }
  CHECK(shown > 0);
  CHECK(shown <= int(pixels_of(bounds)));
}

}  // namespace

TEST_CASE("outside their bounds truths are transparent, and a full volume fills the bounds") {
  const Volume volume =
      make_volume({12, 9, 15}, ScalarType::float32, [](int, int, int) { return 1.0; }, {1, 1.5, 0.7});
  constexpr int size = 56;
  for (const Camera& camera :
       {Camera{}, Camera{.azimuth = 45}, Camera{.azimuth = 20, .elevation = 35, .roll = 7},
        Camera{.azimuth = 200, .elevation = -60, .zoom = 0.3}, Camera{.elevation = 90, .zoom = 0.15},
        Camera{.azimuth = 30, .zoom = 20}}) {
    const FrameSpec spec = plain_spec(constant_opacity(0.4), size, camera);
    INFO("azimuth " << camera.azimuth << ", elevation " << camera.elevation << ", zoom " << camera.zoom);
    const truth::Scene scene = scene_of(volume, spec);
    const Image field = field_image(volume, spec), method = method_image(volume, spec);
    check_bounds(field, field_bounds(scene));
    check_bounds(method, method_bounds(scene));
    const auto shown = [](const Image& image) {
      std::size_t count = 0;
      for (std::size_t k = 3; k < image.rgba.size(); k += 4) count += image.rgba[k] > 0;
      return count;
    };
    CHECK(pixels_of(field_bounds(scene)) == shown(field));
    // Kernels are round, their bounds are not.
    CHECK(double(pixels_of(method_bounds(scene))) < 1.5 * double(shown(method)) + 30);
  }
}

TEST_CASE("a volume beside the picture has no bounds, and the error is known without its truth") {
  const Volume volume = make_volume({8, 8, 8}, ScalarType::uint8, [](int, int, int) { return 200; });
  Camera camera;
  camera.matrix = {1, 0, 0, 500, 0, 1, 0, 500, 0, 0, 1, 0};
  const truth::Scene scene = scene_of(volume, plain_spec(constant_opacity(0.4), 40, camera));
  CHECK(pixels_of(field_bounds(scene)) == 0);
  CHECK(pixels_of(method_bounds(scene)) == 0);
  Image wrong(40, 40);
  wrong.pixel(3, 5)[2] = 0.5F;
  const PixelSample sample = draw_sample(wrong, field_bounds(scene), 100, 1);
  const SampledError error = sampled_error(wrong, sample, {});
  CHECK(error.pixels == 0);
  CHECK(error.outside == 1600);
  CHECK(error.rmse == Approx(127.5 / 80));
  CHECK(error.rmse_low == Approx(error.rmse));
  CHECK(error.rmse_high == Approx(error.rmse));
  CHECK(error.worst == Pixel{3, 5});
}

TEST_CASE("a sample's pixels are different, within the bounds, as many as asked for, from all strata") {
  const Image image = picture();
  for (const std::size_t count : {1, 2, 7, 16, 40, 333, 2000}) {
    const PixelSample sample = draw_sample(image, bounds(), count, 5);
    INFO(count);
    CHECK(sample.pixels.size() == count);
    std::set<std::pair<int, int>> different;
    for (const Pixel p : sample.pixels) {
      CHECK(bounds().rows[std::size_t(p.y)].contains(p.x));
      different.insert({p.y, p.x});
    }
    CHECK(different.size() == count);
    std::size_t belonging = 0, sampled = 0;
    for (const auto& stratum : sample.strata) {
      CHECK(stratum.sampled <= stratum.pixels);
      CHECK(stratum.sampled >= std::min<std::size_t>({2, count, stratum.pixels}));
      belonging += stratum.pixels;
      sampled += stratum.sampled;
    }
    CHECK(belonging == pixels_of(bounds()));
    CHECK(sampled == count);
  }
  const PixelSample all = draw_sample(image, bounds(), 1000000, 5);
  CHECK(all.pixels.size() == pixels_of(bounds()));
  CHECK(draw_sample(image, bounds(), pixels_of(bounds()), 7).pixels.size() == pixels_of(bounds()));
}

TEST_CASE("a sample is the same for the same seed on every machine, and another for another") {
  const auto digest = [](std::uint64_t seed) {
    std::uint64_t hash = 14695981039346656037U;
    for (const Pixel p : draw_sample(picture(), bounds(), 200, seed).pixels)
      hash = (hash ^ std::uint64_t(p.y * width + p.x)) * 1099511628211U;
    return hash;
  };
  CHECK(digest(1) == 0x88b3ec01cf27dd6dU);
  CHECK(digest(1) != digest(2));
}

TEST_CASE("edges are sampled most densely, and flat places never left out") {
  const Image image = picture();
  const PixelSample sample = draw_sample(image, bounds(), 400, 3);
  const auto density = [&](auto&& belongs) {
    int pixels = 0, sampled = 0;
    for (int y = 8; y < height - 8; ++y)
      for (int x = 8; x < width - 8; ++x) pixels += belongs(x, y);
    for (const Pixel p : sample.pixels) sampled += belongs(p.x, p.y);
    return double(sampled) / pixels;
  };
  const double at_the_bar = density([](int, int y) { return y == 31 || y == 32 || y == 35 || y == 36; });
  const double in_the_corner = density([](int x, int y) { return x < 18 && y < 18; });
  CHECK(at_the_bar > 2 * in_the_corner);
  CHECK(in_the_corner > 0);
}

TEST_CASE("of a census the error is that of the comparison, with an interval of no width") {
  const Image image = picture();
  const Image empty(width, height);
  const PixelSample sample = draw_sample(image, bounds(), 1000000, 5);
  const SampledError error = sampled_error(image, sample, nothing(sample));
  const ImageError whole = compare(image, empty);
  CHECK(error.pixels + error.outside == std::size_t(width * height));
  CHECK(error.rmse == Approx(whole.total.rmse).epsilon(1e-12));
  CHECK(error.mean == Approx(whole.total.mean).epsilon(1e-12));
  CHECK(error.largest == whole.total.largest);
  CHECK(error.rmse_low == Approx(error.rmse).epsilon(1e-12));
  CHECK(error.rmse_high == Approx(error.rmse).epsilon(1e-12));
}

TEST_CASE("what is wrong outside the bounds is counted whole") {
  Image image(width, height);
  image.pixel(1, 2)[0] = 1;
  const PixelSample sample = draw_sample(image, bounds(), 50, 5);
  const SampledError error = sampled_error(image, sample, nothing(sample));
  CHECK(error.rmse == Approx(compare(image, Image(width, height)).total.rmse));
  CHECK(error.mean == Approx(255.0 / 4 / (width * height)));
  CHECK(error.largest == 255);
  CHECK(error.worst == Pixel{1, 2});
  CHECK(error.outside == std::size_t(width * height) - pixels_of(bounds()));
}

TEST_CASE("few pixels give a wide interval, one the widest") {
  Image image = picture();
  const auto width_of = [&](std::size_t count) {
    const PixelSample sample = draw_sample(image, bounds(), count, 2);
    const SampledError error = sampled_error(image, sample, nothing(sample));
    CHECK(std::isfinite(error.rmse_high));
    return error.rmse_high / error.rmse_low;
  };
  CHECK(width_of(1) > width_of(20));
  CHECK(width_of(20) > width_of(200));
  CHECK(width_of(200) > width_of(2000));
}

TEST_CASE("a value that is not finite makes the error infinite, sampled or not") {
  Image image = picture();
  image.pixel(20, 20)[1] = std::numeric_limits<float>::quiet_NaN();
  const PixelSample sample = draw_sample(image, bounds(), 20, 2);
  CHECK(std::find(sample.pixels.begin(), sample.pixels.end(), Pixel{20, 20}) == sample.pixels.end());
  const SampledError error = sampled_error(image, sample, nothing(sample));
  CHECK(std::isinf(error.rmse));
  CHECK(std::isinf(error.rmse_high));
  CHECK(error.worst == Pixel{20, 20});
}

#include "raster/warp_image.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "support/catch.hpp"
#include "support/vector_targets.hpp"

using namespace ringsplat;

namespace {

Image image_of(int width, int height, const std::function<double(double, double)>& value) {
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int k = 0; k < 4; ++k)
        image.pixel(x, y)[k] = float((k == 3 ? 1.0 : 0.25 * (k + 1)) * value(x + 0.5, y + 0.5));
  return image;
}

PixelWindow all_of(const Image& image) { return {0, 0, image.width - 1, image.height - 1}; }

Image random_image(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  Image image(width, height);
  for (std::size_t k = 0; k < image.rgba.size(); k += 4) {
    image.rgba[k + 3] = unit(random);
    for (std::size_t c = 0; c < 3; ++c) image.rgba[k + c] = unit(random) * image.rgba[k + 3];
  }
  return image;
}

/// Catmull and Rom's cubic of the sixteen pixels round a place, in double precision, clamped; nothing where
/// they are not all in the image.
std::array<double, 4> cubic_at(const Image& plane, glm::dvec2 place) {
  const glm::dvec2 from = place - 1.5, first = glm::floor(from), t = from - first;
  std::array<double, 4> sum{};
  if (first.x < 0 || first.y < 0 || first.x > plane.width - 4 || first.y > plane.height - 4) return sum;
  const auto weights = [](double f) {
    return std::array{0.5 * f * (-1 + f * (2 - f)), 1 + 0.5 * f * f * (-5 + 3 * f),
                      0.5 * f * (1 + f * (4 - 3 * f)), 0.5 * f * f * (f - 1)};
  };
  const auto wx = weights(t.x), wy = weights(t.y);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      for (std::size_t k = 0; k < 4; ++k)
        sum[k] += wx[std::size_t(x)] * wy[std::size_t(y)] *
                  double(plane.pixel(int(first.x) + x, int(first.y) + y)[k]);
  const double opacity = std::clamp(sum[3], 0.0, 1.0);
  for (double& value : sum) value = std::clamp(value, 0.0, opacity);
  return sum;
}

const PlaneWarp turned{glm::dmat2(0.31, 0.12, -0.17, 0.29), {9.3, 4.1}};
/// The picture's columns lie in columns of the plane.
const PlaneWarp upright{glm::dmat2(0.41, 0.12, 0, 0.53), {2.3, 1.1}};

}  // namespace

TEST_CASE("a warp that moves nothing gives the image") {
  const Image plane = random_image(23, 17, 1);
  const Image screen = warp_image(plane, all_of(plane), {}, 23, 17);
  // The outermost pixels have no four neighbours along each axis.
  for (int y = 1; y < 15; ++y)
    for (int x = 1; x < 21; ++x)
      for (int k = 0; k < 4; ++k) REQUIRE(screen.pixel(x, y)[k] == plane.pixel(x, y)[k]);
}

TEST_CASE("the warp's cubic is exact for quadratics") {
  const auto quadratic = [](double x, double y) {
    return 0.2 + 0.01 * x + 0.006 * y + 0.0002 * x * x - 0.0003 * x * y + 0.0001 * y * y;
  };
  const PlaneWarp warp = GENERATE(turned, upright);
  const Image plane = image_of(40, 36, quadratic);
  const Image screen = warp_image(plane, all_of(plane), warp, 60, 50);
  int seen = 0;
  for (int y = 0; y < screen.height; ++y) {
    for (int x = 0; x < screen.width; ++x) {
      const glm::dvec2 at = warp.from_screen({x + 0.5, y + 0.5});
      if (at.x < 1.5 || at.x >= 38.5 || at.y < 1.5 || at.y >= 34.5) {
        REQUIRE(screen.pixel(x, y)[3] == 0);
        continue;
      }
      ++seen;
      REQUIRE(double(screen.pixel(x, y)[3]) == Approx(quadratic(at.x, at.y)).epsilon(1e-6));
      REQUIRE(double(screen.pixel(x, y)[0]) == Approx(0.25 * quadratic(at.x, at.y)).epsilon(1e-6));
    }
  }
  CHECK(seen > 1000);
}

TEST_CASE("the warp's error falls with the third power of the pixel") {
  const auto error = [](int n) {
    const Image plane = image_of(
        n, n, [n](double x, double y) { return 0.5 + 0.4 * std::sin(7 * x / n) * std::cos(5 * y / n); });
    const double scale = n / 64.0;
    const PlaneWarp warp{glm::dmat2(0.9 * scale, 0.1 * scale, -0.1 * scale, 0.9 * scale),
                         {6.05 * scale, 3.3 * scale}};
    const Image screen = warp_image(plane, all_of(plane), warp, 52, 52);
    double largest = 0;
    for (int y = 4; y < 48; ++y) {
      for (int x = 4; x < 48; ++x) {
        const glm::dvec2 at = warp.from_screen({x + 0.5, y + 0.5}) / double(n);
        largest = std::max(largest, std::abs(double(screen.pixel(x, y)[3]) -
                                             (0.5 + 0.4 * std::sin(7 * at.x) * std::cos(5 * at.y))));
      }
    }
    return largest;
  };
  const double coarse = error(32), fine = error(64);
  INFO(coarse << " and " << fine);
  CHECK(fine > 1e-6);
  CHECK(fine < coarse / 7);
}

TEST_CASE("what the cubic's lobes bring out of range is clamped") {
  Image plane(16, 16);
  for (int y = 0; y < 16; ++y)
    for (int x = 8; x < 16; ++x) std::fill_n(plane.pixel(x, y), 4, 1.0F);
  const Image screen = warp_image(plane, all_of(plane), {glm::dmat2(0.25), {0.0, 0.0}}, 64, 64);
  for (std::size_t k = 0; k < screen.rgba.size(); k += 4) {
    REQUIRE((screen.rgba[k + 3] >= 0 && screen.rgba[k + 3] <= 1));
    for (std::size_t c = 0; c < 3; ++c)
      REQUIRE((screen.rgba[k + c] >= 0 && screen.rgba[k + c] <= screen.rgba[k + 3]));
  }
}

TEST_CASE("leaving out what is empty leaves the picture as it is") {
  Image plane(40, 40);
  const Image inner = random_image(12, 9, 3);
  for (int y = 0; y < 9; ++y) std::copy_n(inner.pixel(0, y), 48, plane.pixel(14, 20 + y));
  for (const PlaneWarp& warp : {turned, upright, PlaneWarp{glm::dmat2(0, 0.5, -0.5, 0), {40.0, 0.0}},
                                PlaneWarp{glm::dmat2(0.7), {0.0, 0.0}}}) {
    const Image whole = warp_image(plane, all_of(plane), warp, 90, 80);
    CHECK(whole == warp_image(plane, {14, 20, 25, 28}, warp, 90, 80));
    CHECK(*std::max_element(whole.rgba.begin(), whole.rgba.end()) > 0.5F);
    CHECK(warp_image(plane, {40, 40, -1, -1}, warp, 90, 80) == Image(90, 80));
  }
}

TEST_CASE("a picture is the cubic of the plane up to its lobes' last corner, whatever is filled") {
  // Slanting edges: rows and columns of the filled part begin and end at other places. And single pixels,
  // of which the corners' lobes are above zero.
  Image slanted(40, 40), dots(40, 40);
  for (int y = 14; y < 24; ++y)
    for (int x = 12 + y % 5; x < 46 - y; ++x) std::fill_n(slanted.pixel(x, y), 4, 0.9F);
  for (const auto& [x, y] : {std::pair{20, 20}, {9, 26}, {30, 12}}) std::fill_n(dots.pixel(x, y), 4, 1.0F);
  for (const Image* plane : {&slanted, &dots})
    for (const PlaneWarp& warp : {turned, upright, PlaneWarp{glm::dmat2(0, 0.37, -0.43, 0), {39.2, 0.3}},
                                  PlaneWarp{glm::dmat2(0.23), {10.1, 5.2}}}) {
      const Image screen = warp_image(*plane, all_of(*plane), warp, 130, 120);
      int faint = 0;
      for (int y = 0; y < screen.height; ++y)
        for (int x = 0; x < screen.width; ++x) {
          const auto expected = cubic_at(*plane, warp.from_screen({x + 0.5, y + 0.5}));
          faint += expected[3] > 0 && expected[3] < 0.006;
          for (std::size_t k = 0; k < 4; ++k)
            REQUIRE(double(screen.pixel(x, y)[k]) == Approx(expected[k]).margin(1e-6));
        }
      CHECK(faint > 0);  // corners of lobes
    }
}

TEST_CASE("every instruction set warps to the same bits") {
  const Image plane = random_image(50, 44, 5);
  const PlaneWarp warp = GENERATE(turned, upright);
  std::vector<Image> pictures;
  for (const auto& target : vector_targets()) {
    use_vector_target(target);
    pictures.push_back(warp_image(plane, all_of(plane), warp, 97, 83));
  }
  use_vector_target("");
  for (const Image& picture : pictures) CHECK(picture == pictures.front());
}

TEST_CASE("an image too small to interpolate in gives an empty picture") {
  const Image plane = random_image(3, 9, 6);
  CHECK(warp_image(plane, all_of(plane), {}, 20, 20) == Image(20, 20));
}

#include <cmath>
#include <limits>
#include <random>

#include "splat/scene.hpp"
#include "splat/splat.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

TEST_CASE("the anchor is the last pixel whose centre is at or before the position", "[encode]") {
  CHECK(anchor_pixel(0.5) == 0);
  CHECK(anchor_pixel(0.49) == -1);
  CHECK(anchor_pixel(1.49) == 0);
  CHECK(anchor_pixel(-0.5) == -1);
  CHECK(anchor_pixel(-0.51) == -2);
  CHECK(anchor_pixel(4095.5) == 4095);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> position(-1e6, 1e6);
  for (int i = 0; i < 10000; ++i) {
    const double x = position(random), y = position(random);
    const auto at = anchor(x, y);
    REQUIRE(at.anchor_x == static_cast<std::int64_t>(std::floor(x - 0.5)));
    REQUIRE(at.dx >= 0);
    REQUIRE(at.dx <= 1);
    REQUIRE(static_cast<double>(at.anchor_x) + 0.5 + at.dx == x);
    REQUIRE(static_cast<double>(at.anchor_y) + 0.5 + at.dy == y);
  }
}

TEST_CASE("positions that are no pixels have an anchor all the same", "[encode]") {
  constexpr double huge = 1e300, nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(anchor_pixel(huge) > (std::int64_t{1} << 39));
  CHECK(anchor_pixel(-huge) < -(std::int64_t{1} << 39));
  CHECK(std::abs(anchor_pixel(nan)) > (std::int64_t{1} << 39));
}

TEST_CASE("the pixel window holds every pixel with Q > 0", "[encode]") {
  const Lattice lattice{GENERATE(0.1, 1.0, 1.17, 1.25, 3.3), 0.4, GENERATE(1.0, 0.6), 0.9, 1};
  const auto footprint = footprint_of(lattice);
  const auto reach = kernel_reach(footprint);
  CHECK(reach.x == static_cast<std::int64_t>(std::floor(footprint.half.x)));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> position(-20, 20);
  for (int i = 0; i < 200; ++i) {
    const double x0 = position(random), y0 = position(random);
    const auto window = pixel_window(anchor(x0, y0), reach);
    CHECK(window.x1 - window.x0 == 2 * reach.x + 1);
    for (int y = -40; y <= 40; ++y) {
      for (int x = -40; x <= 40; ++x) {
        if (direct_q(footprint, {x + 0.5 - x0, y + 0.5 - y0}) <= 0) continue;
        REQUIRE((x >= window.x0 && x <= window.x1 && y >= window.y0 && y <= window.y1));
      }
    }
  }
}

TEST_CASE("a splat has its anchor, its voxel's colour and the rounded coefficients", "[encode]") {
  const auto footprint = footprint_of({1.17, 0.3, 0.8, 0.1, 1});
  const auto exact = coefficients(footprint, 0.25, 0.75);
  const auto splat = make_splat(footprint, {17, 200, 0.25, 0.75}, {1000, 20000, 65535, 0.4F});
  CHECK(splat.a == static_cast<float>(exact.a));
  CHECK(splat.b == static_cast<float>(exact.b));
  CHECK(splat.c == static_cast<float>(exact.c));
  CHECK(splat.opacity == static_cast<float>(static_cast<double>(0.4F) * footprint.weight));
  CHECK(splat.red == 1000);
  CHECK(splat.green == 20000);
  CHECK(splat.blue == 65535);
  CHECK(splat.anchor_x == 17);
  CHECK(splat.anchor_y == 200);
}

TEST_CASE("float32 coefficients give Q to float precision all over a 4096 x 4096 image", "[encode]") {
  const Lattice lattice{GENERATE(0.1, 1.17, 4.7, 18.0), 0.4, GENERATE(1.0, 0.58), 0.9, 1};
  const auto footprint = footprint_of(lattice);
  const auto reach = kernel_reach(footprint);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> in_region(0, 128);
  double worst = 0;
  for (int region = 0; region < 32 * 32; ++region) {
    const double x0 = region % 32 * 128 + in_region(random), y0 = region / 32 * 128 + in_region(random);
    const auto placed = place(footprint, x0, y0, {1, 1, 1, 1});
    for (std::int64_t dy = -reach.y; dy <= reach.y + 1; ++dy) {
      for (std::int64_t dx = -reach.x; dx <= reach.x + 1; ++dx) {
        const auto x = static_cast<float>(dx), y = static_cast<float>(dy);
        const auto k = static_cast<float>(footprint.d * x * x + footprint.e * x * y + footprint.f * y * y);
        const float q = (k + placed.splat.a * x) + (placed.splat.c + placed.splat.b * y);
        const glm::dvec2 pixel(static_cast<double>(placed.splat.anchor_x + dx) + 0.5,
                               static_cast<double>(placed.splat.anchor_y + dy) + 0.5);
        const double exact = direct_q(footprint, pixel - glm::dvec2(x0, y0));
        if (exact > -1) worst = std::max(worst, std::abs(static_cast<double>(q) - exact));
      }
    }
  }
  INFO("largest error " << worst);
  CHECK(worst < 6e-7);
}

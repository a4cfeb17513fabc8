#include <algorithm>
#include <limits>
#include <tuple>

#include "ringsplat/base/error.hpp"
#include "screen/regions.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// Which region holds a pixel, by looking at all of them.
int region_at(const Regions& regions, int x, int y) {
  int found = -1;
  for (int r = 0; r < regions.count(); ++r) {
    const auto rect = regions.rect(r);
    if (x < rect.x0 || x >= rect.x1 || y < rect.y0 || y >= rect.y1) continue;
    REQUIRE(found == -1);
    found = r;
  }
  return found;
}

}  // namespace

TEST_CASE("regions cover every pixel of the screen exactly once", "[regions]") {
  const auto [width, height, size] =
      GENERATE(std::tuple{1, 1, 1}, std::tuple{7, 5, 2}, std::tuple{16, 8, 4}, std::tuple{13, 29, 64},
               std::tuple{10, 3, 10}, std::tuple{11, 21, 10});
  const Regions regions(width, height, size);
  long long area = 0;
  for (int r = 0; r < regions.count(); ++r) {
    const auto rect = regions.rect(r);
    CHECK_FALSE(rect.empty());
    CHECK(rect.width() <= size);
    CHECK(rect.height() <= size);
    area += static_cast<long long>(rect.width()) * rect.height();
  }
  CHECK(area == static_cast<long long>(width) * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int region = region_at(regions, x, y);
      REQUIRE(region >= 0);
      const auto block = regions.touched({x, y, x, y});
      REQUIRE(block == PixelRect{region % regions.columns(), region / regions.columns(),
                                 region % regions.columns() + 1, region / regions.columns() + 1});
    }
  }
}

TEST_CASE("regions may be wider than high", "[regions]") {
  const Regions strips(300, 100, 300, 48);
  CHECK(strips.columns() == 1);
  CHECK(strips.rows() == 3);
  CHECK(strips.rect(2) == PixelRect{0, 96, 300, 100});
  CHECK(strips.touched({-5, 40, 400, 50}) == PixelRect{0, 0, 1, 2});
  const Regions cut(300, 100, 128, 48);
  CHECK(cut.count() == 9);
  CHECK(cut.rect(5) == PixelRect{256, 48, 300, 96});
  CHECK(cut.touched({127, 47, 128, 48}) == PixelRect{0, 0, 2, 2});
  CHECK(cut != strips);
  CHECK_THROWS_AS(Regions(300, 100, 128, 0), InputError);
}

TEST_CASE("a region larger than the screen is the screen", "[regions]") {
  const Regions regions(300, 200, std::numeric_limits<int>::max());
  REQUIRE(regions.count() == 1);
  CHECK(regions.rect(0) == PixelRect{0, 0, 300, 200});
}

TEST_CASE("touched() is the block of regions that a window of pixels meets", "[regions]") {
  const Regions regions(300, 200, 128);
  CHECK(regions.touched({127, 127, 127, 127}) == PixelRect{0, 0, 1, 1});
  CHECK(regions.touched({127, 127, 128, 127}) == PixelRect{0, 0, 2, 1});
  CHECK(regions.touched({126, 126, 129, 129}) == PixelRect{0, 0, 2, 2});
  CHECK(regions.touched({-5, 10, 3, 11}) == PixelRect{0, 0, 1, 1});
  CHECK(regions.touched({-100, -100, 1000, 1000}) == PixelRect{0, 0, 3, 2});
  constexpr auto far = std::numeric_limits<long long>::max();
  CHECK(regions.touched({-far, -far, far, far}) == PixelRect{0, 0, 3, 2});
}

TEST_CASE("touched() is empty off the screen", "[regions]") {
  const Regions regions(300, 200, 128);
  CHECK(regions.touched({-4, 0, -1, 3}).empty());
  CHECK(regions.touched({300, 0, 303, 3}).empty());
  CHECK(regions.touched({0, -9, 3, -1}).empty());
  CHECK(regions.touched({0, 200, 3, 201}).empty());
  CHECK(Regions().touched({0, 0, 0, 0}).empty());
}

TEST_CASE("bad screen and region sizes are refused", "[regions]") {
  CHECK_THROWS_AS(Regions(0, 10, 8), InputError);
  CHECK_THROWS_AS(Regions(10, -1, 8), InputError);
  CHECK_THROWS_AS(Regions(10, 10, 0), InputError);
  CHECK_THROWS_AS(Regions(10, 10, -128), InputError);
  CHECK_THROWS_AS(Regions((1 << 20) + 1, 10, 128), InputError);
  CHECK_THROWS_AS(Regions(1 << 20, 1 << 20, 1), InputError);
  CHECK_NOTHROW(Regions(1 << 20, 1 << 20, 128));
}

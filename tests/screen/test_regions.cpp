#include <algorithm>
#include <limits>
#include <set>
#include <tuple>

#include "ringsplat/base/error.hpp"
#include "screen/regions.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// In columns and rows of regions.
PixelRect all(const Regions& regions) { return {0, 0, regions.columns(), regions.rows()}; }

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

TEST_CASE("Renderers have as many regions as any other or one fewer, wherever in the picture", "[regions]") {
  for (const int columns : {1, 2, 4, 5, 6, 12, 16}) {
    for (int renderers = 1; renderers <= 24; ++renderers) {
      INFO(columns << " regions in a row, " << renderers << " Renderers");
      const Regions regions(columns * 10, 70, 10);
      std::vector<int> owned(std::size_t(renderers), 0);
      for (const int owner : regions.owners(all(regions), renderers, renderers)) ++owned[std::size_t(owner)];
      CHECK(*std::max_element(owned.begin(), owned.end()) <=
            *std::min_element(owned.begin(), owned.end()) + 1);
    }
  }
}

TEST_CASE("regions dealt to some of the Renderers lie with some at even distances", "[regions]") {
  const Regions regions(60, 70, 10);
  for (int renderers = 1; renderers <= 24; ++renderers) {
    for (int dealt_to = 1; dealt_to <= renderers; ++dealt_to) {
      INFO(dealt_to << " of " << renderers << " Renderers");
      const std::vector<int> owners = regions.owners(all(regions), renderers, dealt_to),
                             few = regions.owners(all(regions), dealt_to, dealt_to);
      for (int region = 0; region < regions.count(); ++region)
        REQUIRE(owners[std::size_t(region)] == few[std::size_t(region)] * renderers / dealt_to);
    }
  }
}

TEST_CASE("a block of regions is dealt as if it were the picture, and the others are nobody's", "[regions]") {
  const Regions regions(90, 70, 10);
  for (const PixelRect block :
       {PixelRect{0, 0, 9, 7}, {2, 1, 7, 6}, {8, 6, 9, 7}, {0, 3, 9, 4}, {4, 4, 4, 4}}) {
    for (int renderers = 1; renderers <= 12; ++renderers) {
      INFO(block.x0 << ' ' << block.y0 << ' ' << block.x1 << ' ' << block.y1 << ", " << renderers);
      const Regions part(std::max(block.width(), 1), std::max(block.height(), 1), 1);
      const std::vector<int> owners = regions.owners(block, renderers, renderers),
                             alone = part.owners(all(part), renderers, renderers);
      for (int y = 0; y < regions.rows(); ++y) {
        for (int x = 0; x < regions.columns(); ++x) {
          const bool inside = x >= block.x0 && x < block.x1 && y >= block.y0 && y < block.y1;
          const int owner = owners[std::size_t(y * regions.columns() + x)];
          if (inside)
            REQUIRE(owner == alone[std::size_t((y - block.y0) * block.width() + x - block.x0)]);
          else
            REQUIRE(owner == nobody);
        }
      }
    }
  }
}

TEST_CASE("what lies together in the picture is dealt to many Renderers", "[regions]") {
  const int columns = GENERATE(4, 5, 6, 8, 16);
  const Regions regions(columns * 10, columns * 10, 10);
  for (const int renderers : {2, 3, 4, 5, 8, 16}) {
    const std::vector<int> owners = regions.owners(all(regions), renderers, renderers);
    INFO(columns << " regions in a row, " << renderers << " Renderers");
    for (int y = 0; y + 1 < columns; ++y) {
      for (int x = 0; x + 1 < columns; ++x) {
        const auto corner = owners.begin() + y * columns + x;
        const std::set<int> block{corner[0], corner[1], corner[columns], corner[columns + 1]};
        CHECK(int(block.size()) >= std::min(renderers, 3));
      }
    }
  }
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

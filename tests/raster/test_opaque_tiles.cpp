#include <cmath>
#include <random>

#include "raster/opaque_tiles.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using Cover = OpaqueTiles::Cover;

namespace {

/// Tile by tile.
Cover count_tiles(const OpaqueTiles& tiles, int x0, int y0, int x1, int y1) {
  int inside = 0, opaque = 0;
  for (int row = 0; row < tiles.rows(); ++row)
    for (int column = 0; column < tiles.columns(); ++column) {
      const int left = column * OpaqueTiles::tile_size, top = row * OpaqueTiles::tile_size;
      if (left > x1 || top > y1 || left + OpaqueTiles::tile_size <= x0 || top + OpaqueTiles::tile_size <= y0)
        continue;
      ++inside;
      opaque += tiles.is_opaque(column, row);
    }
  if (opaque == 0) return Cover::none;
  return opaque == inside ? Cover::all : Cover::some;
}

}  // namespace

TEST_CASE("summed areas tell how much of a window is opaque, as counting its tiles does") {
  std::mt19937 random(3);
  for (const auto& [width, height] : {std::pair(128, 128), {7, 300}, {100, 33}, {16, 16}}) {
    OpaqueTiles tiles(width, height);
    std::uniform_int_distribution<int> column(0, tiles.columns() - 1), row(0, tiles.rows() - 1),
        x(-60, width + 60), y(-60, height + 60);
    for (int step = 0; step < tiles.columns() * tiles.rows(); ++step) {
      for (int k = 0; k < 50; ++k) {
        const auto [left, right] = std::pair(x(random), x(random));
        const auto [top, bottom] = std::pair(y(random), y(random));
        const int x0 = std::min(left, right), x1 = std::max(left, right), y0 = std::min(top, bottom),
                  y1 = std::max(top, bottom);
        const Cover expected = count_tiles(tiles, x0, y0, x1, y1);
        REQUIRE(tiles.cover(x0, y0, x1, y1) == expected);
      }
      tiles.set_opaque(column(random), row(random));
      tiles.sum_up();
    }
  }
}

TEST_CASE("before any news nothing is opaque, nor are windows that are no numbers or far away") {
  CHECK_FALSE(OpaqueTiles().worth_asking());
  CHECK(OpaqueTiles().cover(0, 0, 1, 1) == Cover::none);
  OpaqueTiles tiles(32, 32);
  for (int k = 0; k < 4; ++k) tiles.set_opaque(k % 2, k / 2);
  tiles.sum_up();
  CHECK(tiles.cover(-1e300, -1e300, 1e300, 1e300) == Cover::all);
  CHECK(tiles.cover(1e300, 0, 1e301, 5) == Cover::none);
  CHECK(tiles.cover(-5, 0, std::nan(""), 5) == Cover::none);
}

TEST_CASE("opaque tiles hide what lies wholly under them", "[opaque]") {
  OpaqueTiles tiles(40, 33);
  CHECK(tiles.columns() == 3);
  CHECK(tiles.rows() == 3);
  CHECK_FALSE(tiles.hides(0, 0, 39, 32));
  tiles.set_opaque(1, 0);
  tiles.set_opaque(1, 0);
  tiles.set_opaque(2, 0);
  tiles.sum_up();
  CHECK(tiles.opaque() == 2);
  CHECK(tiles.hides(16, 0, 31, 15));
  CHECK(tiles.hides(20, -9, 300, 15));  // what is outside the region needs no tile
  CHECK_FALSE(tiles.hides(15, 0, 20, 5));
  CHECK_FALSE(tiles.hides(20, 10, 20, 16));
  CHECK_FALSE(tiles.hides(-20, 0, -2, 5));  // wholly outside: clipped, not hidden
  CHECK_FALSE(tiles.hides(20, 40, 25, 50));
  tiles.clear();
  CHECK(tiles.opaque() == 0);
  CHECK_FALSE(tiles.hides(16, 0, 31, 15));
}

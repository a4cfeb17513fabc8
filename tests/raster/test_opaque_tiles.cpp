#include "raster/opaque_tiles.hpp"

#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("opaque tiles hide what lies wholly under them", "[opaque]") {
  OpaqueTiles tiles(40, 33);
  CHECK(tiles.columns() == 3);
  CHECK(tiles.rows() == 3);
  CHECK_FALSE(tiles.hides(0, 0, 39, 32));
  tiles.set_opaque(1, 0);
  tiles.set_opaque(1, 0);
  tiles.set_opaque(2, 0);
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

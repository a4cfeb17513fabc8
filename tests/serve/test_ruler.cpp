#include "serve/ruler.hpp"

#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::serve;

namespace {

/// Seen from the front at zoom 1, 200 pixels wide: x to the right, z up, the middle in the middle.
Grid grid() {
  Grid g;
  g.dims = glm::ivec3(41);
  g.spacing = {1, 1, 2};
  return g;
}

Shown shown() {
  Shown s;
  s.width = s.height = 200;
  return s;
}

bool covers(const Patch& patch, int x, int y) {
  const int column = x - patch.x, row = y - patch.y;
  if (column < 0 || row < 0 || column >= patch.width || row >= patch.height) return false;
  return patch.rgba[std::size_t(4 * (row * patch.width + column) + 3)] > 0.5F;
}

Overlay overlay(const Ruler& ruler, const Shown& s = shown()) {
  return ruler_overlay(ruler, s, grid(), "mm", {});
}

}  // namespace

TEST_CASE("A picture's ruler lies on its places, with a text a line and the angle") {
  const Overlay one = overlay({{20, 20, 20}, {30, 20, 20}});
  REQUIRE(one.size() == 2);
  CHECK(covers(one[0], 100, 100));
  CHECK(covers(one[0], 110, 100));
  CHECK_FALSE(covers(one[0], 90, 100));
  CHECK_FALSE(covers(one[0], 100, 110));
  CHECK(one[1].x > 100);
  CHECK(one[1].y + one[1].height < 100);
  CHECK(overlay({{20, 20, 20}, {30, 20, 20}, {30, 20, 30}}).size() == 5);
  CHECK(overlay({{20, 20, 20}}).empty());
}

TEST_CASE("Of a ruler beyond the picture nothing is drawn that is larger than it") {
  Shown s = shown();
  s.camera.zoom = 1000;
  for (const glm::dvec3& far : {glm::dvec3(40, 20, 20), glm::dvec3(40, 20, 40), glm::dvec3(20, 20, 40)})
    for (const Patch& patch : overlay({{20, 20, 20}, far}, s)) {
      CHECK(patch.width < 220);
      CHECK(patch.height < 220);
    }
  CHECK(overlay({{22, 20, 20}, {40, 20, 21}}, s).empty());
  CHECK(overlay({{22, 20, 20}, {22, 20, 40}}, s).empty());
  s.camera = {.fov = 60, .distance = 1};
  CHECK(overlay({{20, -500, 20}, {30, 20, 20}}, s).empty());  // from behind the eye
}

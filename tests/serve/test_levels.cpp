#include "serve/levels.hpp"

#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::serve;

namespace {

constexpr double target = 0.04;

void move(LevelController& controller, double seconds, int pictures) {
  for (int k = 0; k < pictures; ++k) controller.moved(seconds);
}

const Qualities some{{.image_plane = ImagePlane::slices, .light_points = 1},
                     {.image_plane = ImagePlane::slices, .plane_samples = 1.5},
                     {.slabs = 3}};

}  // namespace

TEST_CASE("Levels go from coarse to fine and end with best at full size") {
  const auto levels = make_levels(some, {256, 256, 128});
  REQUIRE(levels.size() == 7);
  CHECK(levels.front().undersample == 4);
  CHECK(levels.back().sheets == some.best);
  CHECK(levels.back().undersample == 1);
  CHECK(!levels.back().half_size);
  for (std::size_t k = 1; k < levels.size(); ++k) CHECK(levels[k].undersample <= levels[k - 1].undersample);
  CHECK(make_levels(some, {40, 100, 100}).front().undersample == 2);
  CHECK(make_levels(some, {1, 100, 100}).front().undersample == 1);
}

TEST_CASE("A half-size level shows the same view in half the pixels, rounded up") {
  FrameSpec full;
  full.shown.width = 101;
  full.shown.height = 1;
  full.shown.camera.zoom = 2;
  const FrameSpec half = at_level(full, {"", 2, true, some.draft});
  CHECK(half.shown.width == 51);
  CHECK(half.shown.height == 1);
  CHECK(half.shown.camera == full.shown.camera);
  CHECK(half.shown.reduction.factor == 2);
}

TEST_CASE("Ten quick pictures make the next level finer, nine do not") {
  LevelController controller(7, target);
  move(controller, 0.5 * target, 9);
  CHECK(controller.level() == 0);
  move(controller, 0.5 * target, 1);
  CHECK(controller.level() == 1);
}

TEST_CASE("Two slow pictures in a row make the next level coarser, one does not") {
  LevelController controller(7, target);
  move(controller, 0.5 * target, 30);
  REQUIRE(controller.level() == 3);
  move(controller, 1.3 * target, 1);
  move(controller, target, 1);
  move(controller, 1.3 * target, 1);
  CHECK(controller.level() == 3);
  move(controller, 1.3 * target, 1);
  CHECK(controller.level() == 2);
}

TEST_CASE("Between the limits the level stays as it is") {
  LevelController controller(7, target);
  move(controller, 0.5 * target, 20);
  move(controller, 0.71 * target, 50);
  move(controller, 1.19 * target, 50);
  CHECK(controller.level() == 2);
}

TEST_CASE("A level that was too slow is not tried again until that is long ago") {
  LevelController controller(7, target);
  move(controller, 0.5 * target, 10);
  move(controller, 2 * target, 2);
  REQUIRE(controller.level() == 0);
  move(controller, 0.5 * target, 90);
  CHECK(controller.level() == 0);
  move(controller, 0.5 * target, 30);
  CHECK(controller.level() >= 1);
}

TEST_CASE("The coarsest level is never left downwards nor the finest upwards") {
  LevelController controller(2, target);
  move(controller, 9 * target, 9);
  CHECK(controller.level() == 0);
  controller.forget();
  move(controller, 0.1 * target, 100);
  CHECK(controller.level() == 1);
}

TEST_CASE("A motion begins at the finest level that was quick at rest") {
  LevelController controller(7, target);
  controller.rested(4, 0.5 * target);
  controller.rested(6, 3 * target);
  controller.begin_motion();
  CHECK(controller.level() == 4);
}

TEST_CASE("At rest there are at most three pictures, the last the best") {
  LevelController controller(7, target);
  CHECK(next_level_at_rest(controller, 7, target, {}) == 0);
  CHECK(next_level_at_rest(controller, 7, target, 0) == 4);
  CHECK(next_level_at_rest(controller, 7, target, 4) == 6);
  CHECK(next_level_at_rest(controller, 7, target, 6) == std::nullopt);
}

TEST_CASE(
    "At rest the middle picture is left out where the best comes soon, and the first where it is quick") {
  LevelController controller(7, target);
  controller.rested(6, 3 * target);
  CHECK(next_level_at_rest(controller, 7, target, {}) == 0);
  CHECK(next_level_at_rest(controller, 7, target, 0) == 6);
  controller.rested(6, target);
  CHECK(next_level_at_rest(controller, 7, target, {}) == 6);
}

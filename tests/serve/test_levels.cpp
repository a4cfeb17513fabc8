#include "serve/levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::serve;

namespace {

constexpr double target = 0.04;

FrameSpec full_frame(int side) {
  FrameSpec full{.how = Splats{}};
  full.shown.width = full.shown.height = side;
  return full;
}

std::vector<double> costs_of(const glm::ivec3& dims, int side) {
  std::vector<double> costs;
  for (const Level& level : make_levels(dims))
    costs.push_back(rough_seconds(at_level(full_frame(side), level), dims));
  return costs;
}

/// A machine whose levels cost another multiple each of what is thought, and no picture exactly as much.
struct Machine {
  std::vector<double> rough, truly;
  std::mt19937 random{7};

  Machine(const glm::ivec3& dims, int side, double slowness, double spread) : rough(costs_of(dims, side)) {
    std::uniform_real_distribution<double> exponent(-1, 1);
    for (const double cost : rough) truly.push_back(cost * slowness * std::pow(spread, exponent(random)));
  }
  double draw(int level) {
    return truly[std::size_t(level)] * std::uniform_real_distribution<double>(0.9, 1.15)(random);
  }
};

/// The seconds of pictures of a view that moves.
std::vector<double> drag(LevelController& controller, Machine& machine, int pictures) {
  std::vector<double> seconds;
  for (int k = 0; k < pictures; ++k) {
    const int level = controller.level();
    seconds.push_back(machine.draw(level));
    controller.took(level, seconds.back());
  }
  return seconds;
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::size_t(share * double(values.size() - 1))];
}

/// A controller for four levels of these costs, of which one picture was seen.
LevelController with_costs(std::vector<double> costs) {
  LevelController controller(target);
  const double first = costs.front();
  controller.expect(std::move(costs));
  controller.took(0, first);
  return controller;
}

}  // namespace

TEST_CASE("Levels go from coarse to fine and end with best at full size") {
  const auto levels = make_levels({256, 256, 128});
  CHECK(levels.front().undersample == 4);
  CHECK(levels.back().sheets == sheets_of(Quality::best));
  CHECK(levels.back().undersample == 1);
  CHECK(levels.back().scale == 1);
  for (std::size_t k = 1; k < levels.size(); ++k) CHECK(levels[k].undersample <= levels[k - 1].undersample);
  CHECK(make_levels({40, 100, 100}).front().undersample == 2);
  CHECK(make_levels({1, 100, 100}).front().undersample == 1);
}

TEST_CASE("A smaller level shows the same view in fewer pixels, rounded up") {
  FrameSpec full = full_frame(1);
  full.shown.width = 101;
  full.shown.camera.zoom = 2;
  const FrameSpec half = at_level(full, {"", 2, 0.5, sheets_of(Quality::draft)});
  CHECK(half.shown.width == 51);
  CHECK(half.shown.height == 1);
  CHECK(half.shown.camera == full.shown.camera);
  CHECK(half.shown.reduction.factor == 2);
}

TEST_CASE("From the first picture on a view that moves gets the finest level that fits") {
  for (const double slowness : {0.1, 0.5, 1.0, 3.0, 20.0}) {
    Machine machine({256, 256, 256}, 768, slowness, 1);
    LevelController controller(target);
    controller.expect(machine.rough);
    const int first = controller.level();
    controller.took(first, machine.truly[std::size_t(first)]);
    const int level = controller.level(), finest = controller.levels() - 1;
    INFO(slowness << ": " << first << ", then " << level);
    CHECK((level == 0 || machine.truly[std::size_t(level)] <= 1.1 * target));
    for (int finer = level + 1; finer <= finest; ++finer)
      CHECK(machine.truly[std::size_t(finer)] > 0.89 * target);
  }
}

TEST_CASE("A level that must not be drawn is left out, also when no other fits") {
  constexpr double never = std::numeric_limits<double>::infinity();
  LevelController controller(target);
  controller.expect({never, 3 * target, 2 * target, never, 0.5 * target});
  controller.took(4, 0.5 * target);
  CHECK(controller.level() == 4);
  controller.expect({never, 3 * target, 2 * target, never, 4 * target});
  CHECK(controller.level() == 2);
}

TEST_CASE("Whatever a machine's levels cost, drags use the target and keep to it") {
  int used = 0;
  for (const int side : {64, 128, 256, 512})
    for (const double slowness : {0.3, 1.0, 3.0}) {
      Machine machine(glm::ivec3(side), 512, slowness, 1.3);
      LevelController controller(target);
      controller.expect(machine.rough);
      drag(controller, machine, 1);
      const std::vector<double> seconds = drag(controller, machine, 400);
      INFO(side << ", " << slowness);
      if (*std::min_element(machine.truly.begin(), machine.truly.end()) > target) continue;
      CHECK(percentile(seconds, 0.95) <= 1.5 * target);
      if (machine.truly.back() < target) continue;
      CHECK(percentile(seconds, 0.5) >= 0.4 * target);
      used += percentile(seconds, 0.5) >= 0.6 * target;
    }
  CHECK(used >= 5);
}

TEST_CASE("One picture that is held up changes little, a dearer view much and at once") {
  LevelController controller = with_costs({0.005, 0.012, 0.025, 0.034, 0.1});
  REQUIRE(controller.level() == 3);
  controller.took(3, 0.034);
  controller.took(3, 10 * target);
  const int after = controller.level();
  CHECK(after >= 2);
  for (int k = 0; k < 6; ++k) controller.took(controller.level(), after == 2 ? 0.025 : 0.034);
  CHECK(controller.level() == 3);
  for (const int level : {3, 2, 1})
    controller.took(level, 4 * std::vector{0.005, 0.012, 0.025, 0.034}[std::size_t(level)]);
  CHECK(controller.level() <= 1);
}

TEST_CASE("A level that fits is not left for one that hardly fits") {
  LevelController controller = with_costs({0.01, 0.034, 0.0375});
  CHECK(controller.level() == 1);
  controller.expect({0.01, 0.043, 0.05});
  CHECK(controller.level() == 1);
  controller.expect({0.01, 0.045, 0.05});
  CHECK(controller.level() == 0);
}

TEST_CASE("At rest there are at most three pictures, the last the best") {
  LevelController controller = with_costs({0.02, 0.06, 0.15, 0.5});
  CHECK(controller.level_at_rest({}) == 0);
  CHECK(controller.level_at_rest(0) == 2);
  CHECK(controller.level_at_rest(2) == 3);
  CHECK(controller.level_at_rest(3) == std::nullopt);
}

TEST_CASE(
    "At rest the middle picture is left out where the best comes soon, and the first where it is quick") {
  LevelController soon = with_costs({0.02, 0.06, 0.1, 0.15});
  CHECK(soon.level_at_rest({}) == 0);
  CHECK(soon.level_at_rest(0) == 3);
  LevelController quick = with_costs({0.01, 0.02, 0.03, 0.05});
  CHECK(quick.level_at_rest({}) == 3);
}

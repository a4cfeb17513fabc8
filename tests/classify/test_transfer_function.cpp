#include <cmath>
#include <limits>
#include <random>

#include "base/srgb.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

TransferFunction ramp() {
  TransferFunction tf;
  tf.colours = {{0, {0, 0, 0}}, {10, {1, 0.5, 0}}};
  tf.opacities = {{2, 0.0}, {4, 0.5}, {8, 0.1}};
  return tf;
}

}  // namespace

TEST_CASE("sRGB and linear light are inverse, with the standard's values") {
  REQUIRE(srgb_to_linear(0.0) == 0.0);
  REQUIRE(srgb_to_linear(1.0) == 1.0);
  REQUIRE(srgb_to_linear(0.5) == Approx(0.21404114).epsilon(1e-8));
  REQUIRE(linear_to_srgb(0.18) == Approx(0.46135613).epsilon(1e-8));
  for (int i = 0; i <= 1000; ++i)
    REQUIRE(linear_to_srgb(srgb_to_linear(i / 1000.0)) == Approx(i / 1000.0).margin(1e-7));
}

TEST_CASE("evaluation is linear between points, in linear light, and constant beyond them") {
  const auto tf = ramp();
  REQUIRE(tf.evaluate(3).opacity == 0.25);
  REQUIRE(tf.evaluate(4).opacity == 0.5);
  REQUIRE(tf.evaluate(6).opacity == Approx(0.3));
  for (const double low : {2.0, -5.0, -1e300, -infinity}) REQUIRE(tf.evaluate(low).opacity == 0.0);
  for (const double high : {8.0, 9.0, 1e300, infinity}) REQUIRE(tf.evaluate(high).opacity == 0.1);
  REQUIRE(tf.evaluate(5).colour.x == Approx(0.5));
  REQUIRE(tf.evaluate(5).colour.y == Approx(0.5 * srgb_to_linear(0.5)));
  REQUIRE(tf.evaluate(-1).colour == glm::dvec3(0));
  REQUIRE(tf.evaluate(infinity).colour == glm::dvec3(1, srgb_to_linear(0.5), 0));
  const auto nan_sample = tf.evaluate(nan_value);
  REQUIRE(nan_sample.opacity == 0.0);
  REQUIRE(nan_sample.colour == glm::dvec3(1, 0, 0));
}

TEST_CASE("equal values make a jump; the last of them holds at the value itself") {
  TransferFunction tf = ramp();
  tf.opacities = {{0, 0.1}, {5, 0.1}, {5, 0.9}, {5, 0.7}, {9, 0.7}};
  REQUIRE(tf.evaluate(std::nextafter(5.0, 0.0)).opacity == Approx(0.1));
  REQUIRE(tf.evaluate(5).opacity == 0.7);
  tf.opacities = {{5, 0.0}, {5, 1.0}};
  REQUIRE(tf.evaluate(4.999).opacity == 0.0);
  REQUIRE(tf.evaluate(5).opacity == 1.0);
}

TEST_CASE("points farther apart than the largest double still interpolate") {
  TransferFunction tf = ramp();
  tf.opacities = {{-1.7e308, 0.0}, {1.7e308, 1.0}};
  REQUIRE(tf.evaluate(0).opacity == Approx(0.5));
  REQUIRE(tf.evaluate(-1.7e308).opacity == 0.0);
  REQUIRE(tf.evaluate(0.85e308).opacity == Approx(0.75));
  tf.opacities = {{0.0, 0.0}, {5e-324, 1.0}};
  REQUIRE(tf.evaluate(0.0).opacity == 0.0);
  REQUIRE(tf.evaluate(5e-324).opacity == 1.0);
}

TEST_CASE("visible_within sees exactly what evaluate sees") {
  const auto tf = ramp();
  REQUIRE_FALSE(tf.visible_within(-10, 2));
  REQUIRE(tf.visible_within(-10, 2.1));
  REQUIRE(tf.visible_within(2, 2.5));
  REQUIRE(tf.visible_within(100, 200));
  REQUIRE(tf.visible_within(-infinity, infinity));
  REQUIRE_FALSE(tf.visible_within(5, 4));
  REQUIRE_FALSE(tf.visible_within(nan_value, 4));

  TransferFunction islands = tf;
  islands.opacities = {{0, 0}, {1, 0}, {2, 1}, {3, 0}, {6, 0}, {6, 1}, {7, 1}, {7, 0}, {9, 0}};
  std::mt19937_64 random(5);
  std::uniform_int_distribution<int> where(0, 80);
  for (int trial = 0; trial < 3000; ++trial) {
    const double a = where(random) / 8.0, b = where(random) / 8.0, low = std::min(a, b),
                 high = std::max(a, b);
    bool seen = false;
    for (int i = 0; i <= 64; ++i) seen = seen || islands.evaluate(low + (high - low) * i / 64).opacity > 0;
    INFO(low << " to " << high);
    REQUIRE(islands.visible_within(low, high) == seen);
  }
}

TEST_CASE("check names the file and the field of what is wrong") {
  const auto message = [](auto change) {
    TransferFunction tf = ramp();
    change(tf);
    return message_of([&] { check(tf, "tf.json"); });
  };
  REQUIRE(message([](TransferFunction&) {}).empty());
  REQUIRE(says(message([](auto& tf) { tf.colours.resize(1); }), "tf.json, RGBPoints has 1 point"));
  REQUIRE(says(message([](auto& tf) { tf.opacities.clear(); }), "tf.json, Points has 0 points"));
  REQUIRE(says(message([](auto& tf) { tf.opacities[1].value = 1; }),
               "Points: point 2 at 1 comes after point 1 at 2"));
  REQUIRE(
      says(message([](auto& tf) { tf.colours[1].value = nan_value; }), "RGBPoints: the value of point 2"));
  REQUIRE(says(message([](auto& tf) { tf.colours[0].value = -infinity; }), "not finite"));
  REQUIRE(says(message([](auto& tf) { tf.opacities[1].opacity = 1.5; }),
               "opacity 1.5 of point 2 is outside 0..1"));
  REQUIRE(says(message([](auto& tf) { tf.opacities[1].opacity = nan_value; }), "outside 0..1"));
  REQUIRE(says(message([](auto& tf) { tf.colours[1].srgb.y = -0.1; }), "colour of point 2 is outside 0..1"));
  REQUIRE(says(message([](auto& tf) { tf.nan_srgb.x = 2; }), "NanColor"));
}

#include <cmath>

#include "classify/paraview_curves.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

TransferFunction with(std::vector<TransferFunction::OpacityPoint> points) {
  TransferFunction tf;
  tf.colours = {{0, {0, 0, 0}}, {1, {1, 1, 1}}};
  tf.opacities = std::move(points);
  return tf;
}

}  // namespace

TEST_CASE("neutral shapes leave the points as they are") {
  const std::vector<TransferFunction::OpacityPoint> points{{0, 0}, {1, 0.3}, {1, 0.8}, {4, 1}};
  REQUIRE(sample_shapes(points, std::vector<CurveShape>(4)) == points);
}

TEST_CASE("a midpoint alone bends the line, full sharpness makes a step there") {
  const auto bent = sample_shapes({{10, 0.2}, {20, 0.6}}, {{0.25, 0}, {}});
  REQUIRE(bent.size() == 3);
  REQUIRE(bent[1].value == 12.5);
  REQUIRE(bent[1].opacity == Approx(0.4));

  const auto step = with(sample_shapes({{10, 0.2}, {20, 0.6}}, {{0.25, 1}, {}}));
  REQUIRE(step.evaluate(12.4999).opacity == 0.2);
  REQUIRE(step.evaluate(12.5).opacity == 0.6);
}

TEST_CASE("the curve is half done at its midpoint, symmetric, monotone, and within its ends") {
  for (const double sharpness : {0.05, 0.3, 0.5, 0.9}) {
    const CurveShape shape{0.5, sharpness};
    REQUIRE(shaped_opacity(0, 1, shape, 0.5) == Approx(0.5));
    REQUIRE(shaped_opacity(0.2, 0.8, {0.3, sharpness}, 0.3) == Approx(0.5));
    double last = 0;
    for (double t = 0; t <= 1; t += 1.0 / 128) {
      const double y = shaped_opacity(0, 1, shape, t);
      REQUIRE(y >= last - 1e-12);
      REQUIRE(y + shaped_opacity(0, 1, shape, 1 - t) == Approx(1.0));
      last = y;
    }
  }
}

TEST_CASE("the curve's values by hand") {
  // Sharpness 0.5 at a quarter of the way: s = 0.5 * 0.5^6 = 1/128;
  // y = s² (3 − 2s) + 0.5 s (1 − s) (1 − 2s).
  const double s = 1.0 / 128;
  REQUIRE(shaped_opacity(0, 1, {0.5, 0.5}, 0.25) ==
          Approx(s * s * (3 - 2 * s) + 0.5 * s * (1 - s) * (1 - 2 * s)).epsilon(1e-13));
  REQUIRE(shaped_opacity(1, 0, {0.5, 0.5}, 0.25) ==
          Approx(1 - s * s * (3 - 2 * s) - 0.5 * s * (1 - s) * (1 - 2 * s)).epsilon(1e-13));
}

TEST_CASE("the sampled points follow the curve to 2e-4") {
  for (const double midpoint : {0.0, 0.1, 0.5, 0.8, 1.0})
    for (const double sharpness : {0.02, 0.2, 0.5, 0.98}) {
      const CurveShape shape{midpoint, sharpness};
      const auto tf = with(sample_shapes({{-3, 0.1}, {5, 1.0}}, {shape, {}}));
      double worst = 0;
      for (int i = 0; i <= 20000; ++i) {
        const double t = i / 20000.0;
        worst =
            std::max(worst, std::abs(tf.evaluate(-3 + 8 * t).opacity - shaped_opacity(0.1, 1.0, shape, t)));
      }
      INFO(midpoint << ' ' << sharpness);
      REQUIRE(worst < 2e-4);
    }
}

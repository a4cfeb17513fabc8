#include <cmath>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "ringsplat/base/error.hpp"
#include "splat/footprint.hpp"
#include "splat/scene.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Weighted sum of all the lattice's kernels at `p` pixels from a voxel.
double lattice_sum(const Footprint& footprint, const glm::dmat2& block, glm::dvec2 p) {
  const auto inverse = glm::inverse(block);
  const auto centre = inverse * p;
  // Half extents of the ellipse in lattice units, row by row of block⁻¹ V block⁻ᵀ.
  const auto root = inverse * glm::inverse(footprint.p);
  const double reach_u = std::hypot(root[0][0], root[1][0]), reach_v = std::hypot(root[0][1], root[1][1]);
  double sum = 0;
  for (double v = std::ceil(centre.y - reach_v); v <= centre.y + reach_v; ++v) {
    for (double u = std::ceil(centre.x - reach_u); u <= centre.x + reach_u; ++u) {
      sum += quartic(direct_q(footprint, p - block * glm::dvec2(u, v)));
    }
  }
  return sum * footprint.weight;
}

struct Ripple {
  double mean, rms, lowest, highest;
};

/// Over a cell of the lattice, at the middles of n × n parts.
Ripple ripple_of(const Footprint& footprint, const glm::dmat2& block, int n) {
  double sum = 0, squares = 0, lowest = 1e9, highest = -1e9;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const double s = lattice_sum(footprint, block, block * glm::dvec2((i + 0.5) / n, (j + 0.5) / n));
      sum += s;
      squares += s * s;
      lowest = std::min(lowest, s);
      highest = std::max(highest, s);
    }
  }
  const double mean = sum / (n * n);
  return {mean, std::sqrt(squares / (n * n) - mean * mean), lowest, highest};
}

const Lattice isotropic{}, oblique{1, 0.4, 0.6, 0.9, 1}, anisotropic{1, 0.3, 1, 0, 3},
    both{1, 0.7, 0.58, 0.2, 0.4};

Lattice scaled(Lattice lattice, double scale) {
  lattice.scale = scale;
  return lattice;
}

}  // namespace

TEST_CASE("P takes pixels to lattice offsets in units of the radius", "[footprint]") {
  const auto lattice =
      GENERATE(scaled(isotropic, 1.17), scaled(oblique, 2), scaled(anisotropic, 3), scaled(both, 5));
  const auto axis = GENERATE(Axis::x, Axis::y, Axis::z);
  const double radius = GENERATE(1.5, 1.6, 2.0);
  const auto footprint = make_footprint(view_of(lattice, axis), axis, radius);
  const auto block = block_of(lattice);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> offset(-3, 3);
  for (int i = 0; i < 50; ++i) {
    const glm::dvec2 lattice_offset(offset(random), offset(random));
    const double r = glm::length(lattice_offset) / radius;
    CHECK(direct_q(footprint, block * lattice_offset) == Approx(1 - r * r).margin(1e-12));
  }
  CHECK(footprint.weight == Approx(3 / (std::numbers::pi * radius * radius)).epsilon(1e-12));
}

TEST_CASE("the quadratic's coefficients expand 1 - |P(p - p0)|^2", "[footprint]") {
  const auto footprint =
      footprint_of(GENERATE(scaled(isotropic, 0.2), scaled(oblique, 1.17), scaled(both, 40)));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1), pixel(-70, 70);
  for (int i = 0; i < 500; ++i) {
    const double x0 = unit(random), y0 = unit(random), x = std::floor(pixel(random)),
                 y = std::floor(pixel(random));
    const auto q = coefficients(footprint, x0, y0);
    const double sum =
        q.a * x + q.b * y + q.c + footprint.d * x * x + footprint.e * x * y + footprint.f * y * y;
    CHECK(sum == Approx(direct_q(footprint, {x - x0, y - y0})).epsilon(1e-11).margin(1e-11));
  }
}

TEST_CASE("half extents bound the ellipse and are reached by it", "[footprint]") {
  const auto footprint =
      footprint_of(GENERATE(scaled(isotropic, 0.1), scaled(oblique, 1), scaled(anisotropic, 0.5), both));
  double right = 0, down = 0;
  for (int i = 0; i < 100000; ++i) {
    const double angle = i * 2 * std::numbers::pi / 100000;
    const auto edge = glm::inverse(footprint.p) * glm::dvec2(std::cos(angle), std::sin(angle));
    right = std::max(right, edge.x);
    down = std::max(down, edge.y);
  }
  CHECK(footprint.half.x == Approx(right).epsilon(1e-8));
  CHECK(footprint.half.y == Approx(down).epsilon(1e-8));
}

TEST_CASE("the lattice sum's ripple is the quartic's own", "[footprint]") {
  struct Expected {
    double radius, rms;
  };
  const auto expected = GENERATE(Expected{1.5, 0.0106}, Expected{1.55, 0.0058}, Expected{1.6, 0.0097},
                                 Expected{1.7, 0.0163}, Expected{2.0, 0.0058});
  const auto ripple =
      ripple_of(footprint_of(scaled(isotropic, 4), expected.radius), block_of(scaled(isotropic, 4)), 100);
  CHECK(ripple.mean == Approx(1).epsilon(1e-4));
  CHECK(ripple.rms == Approx(expected.rms).margin(2e-4));
  if (expected.radius == 1.6) {
    CHECK(ripple.lowest == Approx(1 - 0.032).margin(5e-4));
    CHECK(ripple.highest == Approx(1 + 0.012).margin(5e-4));
  }
}

TEST_CASE("weights average to one at every zoom, on every lattice", "[footprint]") {
  const auto shape = GENERATE(isotropic, oblique, anisotropic, both);
  const double scale = GENERATE(0.02, 0.05, 0.1, 0.3, 0.5, 0.625, 0.7, 1.0, 1.17, 2.0, 5.0);
  const double radius = GENERATE(1.5, 1.6, 2.0);
  const auto lattice = scaled(shape, scale);
  const auto ripple = ripple_of(footprint_of(lattice, radius), block_of(lattice), 16);
  INFO("scale " << scale << " radius " << radius);
  CHECK(ripple.mean == Approx(1).margin(1e-3));
  // A kernel that is widened in one direction only is no circle on the lattice and has a ripple of its own.
  CHECK(ripple.lowest > 1 - 0.05);
  CHECK(ripple.highest < 1 + 0.05);
}

TEST_CASE("no ellipse is narrower than a pixel", "[footprint]") {
  const auto shape = GENERATE(isotropic, oblique, anisotropic, both);
  const double scale = GENERATE(1e-6, 0.02, 0.3, 0.6, 1.0);
  const auto footprint = footprint_of(scaled(shape, scale));
  for (int i = 0; i < 360; ++i) {
    const double angle = i * std::numbers::pi / 180;
    const auto edge = glm::inverse(footprint.p) * glm::dvec2(std::cos(angle), std::sin(angle));
    CHECK(glm::length(edge) > narrowest_half_width * (1 - 1e-9));
  }
  CHECK(std::isfinite(footprint.weight));
}

TEST_CASE("widening sets in continuously with zoom and with tilt", "[footprint]") {
  const auto difference = [](const Footprint& a, const Footprint& b) {
    return std::max(
        {std::abs(a.d - b.d), std::abs(a.e - b.e), std::abs(a.f - b.f), std::abs(a.weight - b.weight)});
  };
  for (int i = 100; i < 1000; ++i) {
    CHECK(difference(footprint_of(scaled(both, i * 0.002)), footprint_of(scaled(both, i * 0.002 + 1e-9))) <
          1e-6);
    CHECK(difference(footprint_of({1.17, 0.3, i * 0.001, 0.5, 1}),
                     footprint_of({1.17, 0.3, i * 0.001 + 1e-9, 0.5, 1})) < 1e-6);
  }
}

TEST_CASE("a voxel below the pixel's size keeps its weight wherever it lies", "[footprint]") {
  const auto lattice = scaled(GENERATE(isotropic, oblique, both), GENERATE(0.02, 0.1, 0.3));
  const auto footprint = footprint_of(lattice);
  const double cell = std::abs(glm::determinant(block_of(lattice)));
  for (int j = 0; j < 10; ++j) {
    for (int i = 0; i < 10; ++i) {
      double sum = 0;
      for (int y = -4; y <= 5; ++y) {
        for (int x = -4; x <= 5; ++x) sum += quartic(direct_q(footprint, {x - i / 10.0, y - j / 10.0}));
      }
      CHECK(sum * footprint.weight / cell == Approx(1).margin(0.1));
    }
  }
}

TEST_CASE("pass_stride is the smallest stride of disjoint kernels", "[footprint]") {
  CHECK(pass_stride(1.6) == 4);
  CHECK(pass_stride(1.5) == 3);
  CHECK(pass_stride(2.0) == 4);
  CHECK(pass_stride(0.5) == 1);
  CHECK(pass_stride(8) == 16);
  for (double radius = 0.5; radius <= 8; radius += 0.07) {
    CHECK(pass_stride(radius) >= 2 * radius);
    CHECK(pass_stride(radius) - 1 < 2 * radius);
  }
}

TEST_CASE("bad radii and views are refused", "[footprint]") {
  const auto view = view_of(isotropic);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   infinity = std::numeric_limits<double>::infinity();
  for (const double radius : {0.0, 0.49, 8.01, -1.6, nan, infinity}) {
    CHECK_THROWS_AS(make_footprint(view, Axis::z, radius), InputError);
  }
  CHECK_NOTHROW(make_footprint(view, Axis::z, 0.5));
  CHECK_NOTHROW(make_footprint(view, Axis::z, 8));
  for (const double scale : {1e9, 1e300, infinity, nan}) {
    CHECK_THROWS_AS(make_footprint(view_of(scaled(isotropic, scale)), Axis::z, 1.6), InputError);
  }
}

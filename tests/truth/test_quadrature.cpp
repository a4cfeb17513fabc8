// The adaptive integral ends whatever is asked of it: bounds of counted evaluations.
#include <fmt/format.h>

#include <limits>
#include <numbers>

#include "support/catch.hpp"
#include "truth/quadrature.hpp"
#include "truth/ray.hpp"
#include "truth/slab_integral.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

struct Counted {
  truth::Piece piece;
  long evaluations = 0;
};

/// The piece [a, b] of white matter whose opacity a unit length is `opacity(s)`.
template <class F>
Counted counted(const F& opacity, double a, double b, double tolerance) {
  Counted result;
  const auto at = [&](double s) {
    ++result.evaluations;
    return truth::Medium{truth::extinction(opacity(s)), glm::dvec3(1.0)};
  };
  result.piece = truth::integrate(at, a, b, tolerance);
  return result;
}

constexpr double tolerances[] = {1e-3, 1e-6, 1e-9, 1e-12, 1e-20, 1e-300, 5e-324};

}  // namespace

TEST_CASE("opacity that rises to exactly 1 is integrated in few evaluations, to any tolerance") {
  // The integral of -ln(1 - o) over a rise from 0 to 1 is its width.
  for (const double width : {1.0, 0.04, 1e-5})
    for (const double tolerance : tolerances)
      for (const bool rising : {true, false}) {
        INFO(fmt::format("{} {} wide, to {}", rising ? "up" : "down", width, tolerance));
        const auto opacity = [&](double s) {
          const double part = std::clamp((s - 100) / width, 0.0, 1.0);
          return rising ? part : 1 - part;
        };
        const auto made = counted(opacity, 100, 100 + width, tolerance * width);
        CHECK(made.evaluations < 6000);
        CHECK(std::abs(made.piece.transmittance - std::exp(-width)) < std::max(tolerance, 1e-11));
      }
}

TEST_CASE("a smooth integral that is asked for less than rounding ends") {
  constexpr double round = 2 * std::numbers::pi;
  for (const double tolerance : tolerances) {
    INFO("to " << tolerance);
    const auto made = counted([](double s) { return 0.5 + 0.4 * std::sin(s); }, 0, round, tolerance);
    CHECK(made.evaluations < 20000);
    // The integral of -ln(0.5 - 0.4 sin s): of a - b sin s it is 2 pi ln((a + sqrt(a^2 - b^2)) / 2).
    CHECK(std::abs(made.piece.transmittance - std::pow(0.4, round)) < std::max(tolerance, 1e-12));
  }
}

TEST_CASE("values that rounding makes stairs are not halved at each step without end") {
  // A rise of 1 over a length of 1 about 4e9: two million steps.
  const auto opacity = [](double s) { return (4e9 + s) - 4e9; };
  for (const double tolerance : {1e-6, 1e-12, 1e-300}) {
    INFO("to " << tolerance);
    const auto made = counted(opacity, 0, 1, tolerance);
    CHECK(made.evaluations <= 15 + 20 * truth::all_halvings);
    CHECK(std::abs(made.piece.transmittance - std::exp(-1.0)) < 3e-4);
  }
  // Noise, which no halving makes smooth.
  const auto noise = [](double s) { return 0.5 + 0.5 * std::sin(1e15 * s); };
  const auto made = counted(noise, 1, 2, 1e-300);
  CHECK(made.evaluations <= 15 + 20 * truth::all_halvings);
  CHECK(std::isfinite(made.piece.transmittance));
}

TEST_CASE("a jump is found to the smallest tolerance that a double can show") {
  const double edge = 100 + 1 / 3.0;
  const auto made = counted([&](double s) { return s < edge ? 0.0 : 0.9; }, 100, 101, 1e-13);
  CHECK(made.evaluations < 1000);
  CHECK(std::abs(made.piece.transmittance - std::pow(0.1, 101 - edge)) < 1e-11);
}

TEST_CASE("the field's truth ends where opacity reaches 1 steeply, to any tolerance, with one result") {
  // Values in Hounsfield's units, steps of 400 from voxel to voxel, and a sheet of one voxel.
  const Volume steep = make_volume({8, 8, 8}, ScalarType::float64, [](int x, int y, int z) {
    return -100 + 400 * ((x + y + z) % 3) + 7 * x;
  });
  const Volume sheet =
      make_volume({8, 8, 8}, ScalarType::float64, [](int, int y, int) { return y == 4 ? 1000 : 0; });
  TransferFunction tf;
  tf.colours = {{0, {1, 0.5, 0.2}}, {300, {1, 1, 1}}};
  tf.opacities = {{250, 0.0}, {300, 1.0}};
  for (const Volume* volume : {&steep, &sheet}) {
    const auto scene = scene_of(*volume, plain_spec(tf, 8, {.azimuth = 31, .elevation = 17, .zoom = 1.1}));
    const std::vector<truth::Pixel> pixels{{4, 4}, {3, 4}, {4, 3}};
    const auto usual = truth::field_truth(scene, pixels, 1e-6);
    for (const double tolerance : {1e-9, 1e-12, 1e-300, std::numeric_limits<double>::min()}) {
      INFO("to " << tolerance);
      const auto fine = truth::field_truth(scene, pixels, tolerance);
      for (std::size_t p = 0; p < pixels.size(); ++p)
        for (int c = 0; c < 4; ++c) CHECK(fine[p][c] == Approx(usual[p][c]).margin(1e-6));
    }
  }
}

TEST_CASE("a slab of the smallest opacities is integrated as others are") {
  TransferFunction tf = constant_opacity(0);
  for (const double least : {1e-300, 1e-318, 5e-324}) {
    tf.opacities = {{0, least}, {0.3, 0.0}, {1, least}};
    const auto slab = truth::integrate_slab(truth::TransferCurve(tf), 0, 1, 1);
    CHECK(slab.opacity <= least);
    CHECK(slab.centroid >= 0);
    CHECK(slab.centroid <= 1);
  }
}

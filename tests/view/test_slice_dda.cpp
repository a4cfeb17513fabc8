#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "support/catch.hpp"
#include "view/slice_dda.hpp"

using namespace ringsplat;

TEST_CASE("a row's positions are the projections of its voxels") {
  const LatticeFrame lattice{.dims = {40, 30, 20}, .spacing = {1, 1.5, 0.7}, .origin = {5, 6, 7}};
  const auto view = make_view({.azimuth = 31, .elevation = -17, .roll = 3}, lattice, 500, 400);
  for (const Axis axis : all_axes) {
    const auto [u, v] = in_plane(axis);
    SliceDda dda(view, axis, lattice.dims[u]);
    dda.begin_row(4, 9);
    for (int i = 0; i < lattice.dims[u]; ++i) {
      glm::dvec3 p{0};
      p[u] = i;
      p[v] = 9;
      p[int(axis)] = 4;
      REQUIRE(glm::distance(dda.position(std::uint32_t(i)), view.project(p)) < 1e-11);
    }
  }
}

TEST_CASE("along 4096 voxels a position is as near to start + n step as the stated bound") {
  constexpr int row_length = 4096;
  const LatticeFrame lattice{.dims = glm::ivec3(row_length)};
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> angle(-180, 180);
  double worst = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const double zoom = trial % 2 ? 1.0 : 40.0;  // 40: most of the row lies far off the screen
    const auto view = make_view(
        {.azimuth = angle(random), .elevation = angle(random) / 2, .roll = angle(random), .zoom = zoom},
        lattice, 4096, 4096);
    const Axis axis = all_axes[std::size_t(trial % 3)];
    SliceDda dda(view, axis, row_length);
    dda.begin_row(trial * 67, 4095 - trial * 31);
    const glm::dvec3 start = dda.position(0), step = view.linear[in_plane(axis).u];
    for (int n = 0; n < row_length; ++n)
      for (int k = 0; k < 3; ++k) {
        const double position = dda.position(std::uint32_t(n))[k];
        const long double along = static_cast<long double>(n) * step[k];
        const double error = double(std::abs(position - (static_cast<long double>(start[k]) + along)));
        worst = std::max(worst, error);
        // The reference is itself rounded to 64 bits, hence a little more than the bound.
        REQUIRE(error <= 1.001 * std::ldexp(double(std::abs(along)) + std::abs(position), -53));
      }
  }
  REQUIRE(worst > 0);      // the bound was tested: some view does round
  REQUIRE(worst < 1e-10);  // far below a splat's float32 offset (half a unit: 6e-8)
}

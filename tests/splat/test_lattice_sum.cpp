#include <fmt/format.h>

#include <cmath>
#include <glm/matrix.hpp>
#include <random>

#include "ringsplat/base/error.hpp"
#include "splat/frame_kernel.hpp"
#include "splat/scene.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// The sum over all voxels whose kernels reach, straight from the definition.
double direct_sum(const Footprint& footprint, const glm::dmat2& block, glm::dvec2 lattice) {
  const glm::dmat2 radii = glm::inverse(footprint.p * block);
  const double u_reach = std::hypot(radii[0][0], radii[1][0]), v_reach = std::hypot(radii[0][1], radii[1][1]);
  double sum = 0;
  for (double v = std::ceil(lattice.y - v_reach); v <= lattice.y + v_reach; ++v)
    for (double u = std::ceil(lattice.x - u_reach); u <= lattice.x + u_reach; ++u)
      sum += quartic(direct_q(footprint, block * (lattice - glm::dvec2(u, v))));
  return sum * footprint.weight;
}

const Lattice lattices[] = {{0.02, 0.4, 0.7, 0.9, 1},  {0.3, 0.2, 0.6, 0.7, 1}, {1.3, 0, 1, 0, 1},
                            {1.17, 0.4, 0.58, 0.9, 1}, {0.4, 0.3, 0.8, 0.2, 9}, {12, 1.4, 0.58, 0.2, 0.5}};

}  // namespace

TEST_CASE("the tabled sum is the lattice's sum to 1e-5", "[lattice-sum]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-40, 40);
  for (const auto& lattice : lattices)
    for (const double radius : {1.0, 1.2, 1.6, 2.5}) {
      const auto footprint = footprint_of(lattice, radius);
      const auto block = block_of(lattice);
      const LatticeSum sum(footprint, block);
      double worst = 0, worst_exact = 0, ripple = 0;
      for (int k = 0; k < (lattice.scale < 0.1 ? 200 : 5000); ++k) {
        const glm::dvec2 at{place(random), place(random)};
        const double expected = direct_sum(footprint, block, at);
        worst_exact = std::max(worst_exact, std::abs(sum.exact(at) / expected - 1));
        float pixel[4] = {1, 1, 1, 1};
        sum.divide_row(pixel, 1, 0, 0, 0.5 - block * at);
        worst = std::max(worst, std::abs(double(pixel[0]) * expected - 1));
        ripple = std::max(ripple, std::abs(expected - 1));
      }
      UNSCOPED_INFO(
          fmt::format("{} pixels a voxel, radius {}: table {:.2g}, sum itself {:.2g}, ripple {:.2g}",
                      lattice.scale, radius, worst, worst_exact, ripple));
      CHECK(worst < 1e-5);
      CHECK(worst_exact < 1e-6);
      if (lattice.scale > 1 && radius == 1.6) CHECK(ripple > 0.02);  // there is something to divide by
    }
}

TEST_CASE("a row is divided by the sum at its pixels' centres, wherever it begins", "[lattice-sum]") {
  const Lattice lattice{1.3, 0.4, 0.8, 0.9, 1};
  const auto footprint = footprint_of(lattice);
  const auto block = block_of(lattice);
  const LatticeSum sum(footprint, block);
  const glm::dvec2 voxel{1234.56, -78.9};
  std::vector<float> whole(4 * 64, 0.5F), parts = whole;
  sum.divide_row(whole.data(), 64, 100000, 7, voxel);
  sum.divide_row(parts.data(), 17, 100000, 7, voxel);
  sum.divide_row(parts.data() + 4 * 17, 47, 100017, 7, voxel);
  CHECK(same_bits(whole, parts));
  for (int x = 0; x < 64; ++x) {
    const glm::dvec2 at = glm::inverse(block) * (glm::dvec2(100000.5 + x, 7.5) - voxel);
    const double expected = 0.5 / direct_sum(footprint, block, at);
    CHECK(double(whole[std::size_t(4 * x)]) == Approx(expected).epsilon(1e-5));
  }
}

TEST_CASE("kernels thousands of voxels wide cost no more and sum to 1", "[lattice-sum]") {
  for (const double scale : {1e-3, 1e-6}) {
    const Lattice lattice{scale, 0.4, 0.7, 0.9, 1};
    const LatticeSum sum(footprint_of(lattice), block_of(lattice));
    for (const double u : {0.0, 0.3, 0.5, 777.7}) CHECK(sum.exact({u, 2 * u}) == Approx(1).epsilon(1e-6));
  }
}

TEST_CASE("kernel options that cannot be or have no effect are refused", "[kernel-options]") {
  const auto refused = [](const KernelOptions& options, double radius, const std::string& named) {
    try {
      check(options, radius);
    } catch (const InputError& e) {
      return std::string(e.what()).find(named) != std::string::npos;
    }
    return false;
  };
  CHECK(refused({.phases = 0}, 1.6, "--phases"));
  CHECK(refused({.phases = 17}, 1.6, "--phases"));
  CHECK(refused({.qee_bits = 1}, 1.6, "--qee-bits"));
  CHECK(refused({.qee_bits = 17}, 1.6, "--qee-bits"));
  CHECK(refused({.method = KernelMethod::texture, .qee_bits = 10}, 1.6, "--kernel qee"));
  CHECK(refused({.normalisation = Normalisation::exact}, 0.99, "--radius"));
  check({.normalisation = Normalisation::exact}, 1.0);
  check({.qee_bits = 10}, 0.5);
  const auto wide = footprint_of({700, 0, 1, 0, 1});
  CHECK_THROWS_AS(check({.method = KernelMethod::texture}, wide), InputError);
  CHECK_THROWS_AS(check({.qee_bits = 10}, footprint_of({3000, 0, 1, 0, 1})), InputError);
  check({.qee_bits = 10}, wide);
  check(KernelOptions{}, wide);
}

TEST_CASE("where voxels lie whole pixels apart the sum has a value for each pixel of a voxel",
          "[lattice-sum]") {
  for (const double step : {1.0, 2.0, 4.0}) {
    for (const double radius : {1.0, 1.6}) {
      const Lattice lattice{step, 0, 1, 0, 1};
      const auto footprint = footprint_of(lattice, radius);
      const auto block = block_of(lattice);
      const LatticeSum sum(footprint, block);
      const glm::dvec2 voxel{-17.28125, 301.59375};
      std::vector<float> whole(4 * 40, 0.5F), parts = whole;
      sum.divide_row(whole.data(), 40, -21, 9, voxel);
      sum.divide_row(parts.data(), 13, -21, 9, voxel);
      sum.divide_row(parts.data() + 4 * 13, 27, -8, 9, voxel);
      CHECK(same_bits(whole, parts));
      for (int x = 0; x < 40; ++x) {
        const glm::dvec2 at = (glm::dvec2(-20.5 + x, 9.5) - voxel) / step;
        for (std::size_t c = 0; c < 4; ++c)
          REQUIRE(double(whole[std::size_t(4 * x) + c]) ==
                  Approx(0.5 / direct_sum(footprint, block, at)).epsilon(1e-6));
      }
    }
  }
}

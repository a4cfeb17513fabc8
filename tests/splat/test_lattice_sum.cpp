#include <fmt/format.h>

#include <cmath>
#include <glm/matrix.hpp>
#include <random>

#include "ringsplat/base/bytes.hpp"
#include "splat/lattice_sum.hpp"
#include "splat/scene.hpp"
#include "support/catch.hpp"
#include "support/vector_targets.hpp"

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

/// A region of a slice that is divided by the lattice's sum.
std::vector<float> paint(const FrameKernel& kernel, const std::vector<Placed>& splats, int x0, int y0,
                         int width, int height) {
  RegionPainter painter(x0, y0, width, height);
  painter.begin_frame(kernel);
  draw_all(painter, splats);
  painter.composite({3.3, 4.4});
  return tile_of(painter, width, height);
}

const Lattice lattices[] = {{0.02, 0.4, 0.7, 0.9, 1},  {0.3, 0.2, 0.6, 0.7, 1}, {1.3, 0, 1, 0, 1},
                            {1.17, 0.4, 0.58, 0.9, 1}, {0.4, 0.3, 0.8, 0.2, 9}, {12, 1.4, 0.58, 0.2, 0.5},
                            {60, 0.4, 0.7, 0.9, 1}};

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

TEST_CASE("divided slices have the same bits in regions of any size and by every instruction set",
          "[lattice-sum][vector]") {
  constexpr int size = 160;
  for (const auto& lattice : lattices) {
    const FrameKernel kernel = exact_kernel(footprint_of(lattice), view_of(lattice));
    const auto splats = random_splats(kernel.footprint, 300, -20, -20, size + 20, size + 20, 1);
    use_vector_target("");
    const auto whole = paint(kernel, splats, 0, 0, size, size);
    REQUIRE(*std::max_element(whole.begin(), whole.end()) > 1e-6F);
    for (const auto& target : vector_targets()) {
      use_vector_target(target);
      INFO(target << ", " << lattice.scale << " pixels a voxel");
      CHECK(same_bits(paint(kernel, splats, 0, 0, size, size), whole));
    }
    use_vector_target("");
    constexpr int part = 37;
    for (int y0 = 0; y0 < size; y0 += part)
      for (int x0 = 0; x0 < size; x0 += part) {
        const int width = std::min(part, size - x0), height = std::min(part, size - y0);
        const auto tile = paint(kernel, splats, x0, y0, width, height);
        for (int y = 0; y < height; ++y) {
          const auto row = whole.begin() + 4 * ((y0 + y) * size + x0);
          REQUIRE(std::equal(row, row + 4 * width, tile.begin() + 4 * y * width));
        }
      }
  }
}

TEST_CASE("no bytes from outside can break a divided slice", "[lattice-sum][fuzz]") {
  std::mt19937 random(17);
  std::uniform_int_distribution<int> byte(0, 255), size(1, 70), base(-300, 300);
  for (const auto& lattice : lattices) {
    const FrameKernel kernel = exact_kernel(footprint_of(lattice), view_of(lattice));
    for (int round = 0; round < 10; ++round) {
      const int width = size(random), height = size(random);
      RegionPainter painter(0, 0, width, height);
      painter.begin_frame(kernel);
      Bytes bytes(200 * sizeof(Splat));
      for (auto& value : bytes) value = static_cast<std::byte>(byte(random));
      const auto counts = painter.draw(base(random), base(random), bytes);
      CHECK(counts.drawn + counts.clipped == 200);
      painter.composite();
      for (const float value : tile_of(painter, width, height)) REQUIRE((value >= 0 && value <= 1.0001F));
    }
  }
}

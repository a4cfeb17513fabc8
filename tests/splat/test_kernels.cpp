// Kernels from a table and in fixed point.
#include <fmt/format.h>

#include <cmath>
#include <random>

#include "ringsplat/base/bytes.hpp"
#include "splat/scene.hpp"
#include "splat/splat_sum.hpp"
#include "support/catch.hpp"
#include "support/vector_targets.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Lattice lattices[] = {{0.1, 0.4, 0.7, 0.9, 1}, {1.3, 0, 1, 0, 1},         {1.17, 0.4, 0.58, 0.9, 1},
                            {4.7, 0.4, 0.7, 0.9, 1}, {12, 1.4, 0.58, 0.2, 0.5}, {60, 0.4, 0.7, 0.9, 1}};

const KernelOptions kernels[] = {{.method = KernelMethod::texture, .phases = 1},
                                 {.method = KernelMethod::texture, .phases = 4},
                                 {.method = KernelMethod::texture, .phases = 16},
                                 {.qee_bits = 10},
                                 {.qee_bits = 16},
                                 {.normalisation = Normalisation::exact},
                                 {.method = KernelMethod::texture, .normalisation = Normalisation::exact}};

FrameKernel kernel_of(const Lattice& lattice, const KernelOptions& options) {
  return make_frame_kernel(footprint_of(lattice), view_of(lattice), Axis::z, options);
}

constexpr glm::dvec2 voxel{3.3, 4.4};

std::vector<float> paint(const FrameKernel& kernel, const std::vector<std::vector<Placed>>& slices, int x0,
                         int y0, int width, int height) {
  RegionPainter painter(x0, y0, width, height);
  painter.begin_frame(kernel);
  for (const auto& slice : slices) {
    draw_all(painter, slice);
    painter.composite(voxel);
  }
  return tile_of(painter, width, height);
}

/// What one splat of opacity 1 and weight 1 leaves in a tile of n × n pixels: the kernel itself.
std::vector<float> kernel_alone(const FrameKernel& kernel, double x, double y, int n) {
  Footprint raw = kernel.footprint;
  raw.weight = 1;
  RegionPainter painter(0, 0, n, n);
  painter.begin_frame(kernel);
  draw_all(painter, {place(raw, x, y, {1, 1, 1, 1})});
  painter.composite();
  return tile_of(painter, n, n);
}

}  // namespace

TEST_CASE("a texture draws the kernel at the nearest phase", "[kernels]") {
  for (const auto& lattice : lattices)
    for (const int phases : {1, 2, 4, 16}) {
      const auto kernel = kernel_of(lattice, {.method = KernelMethod::texture, .phases = phases});
      const int known = std::get<TabledWeights>(kernel.weights).table->phases;
      CHECK((known == phases || lattice.scale > 50));  // wide kernels have fewer
      const int n = 2 * int(std::max(kernel.footprint.half.x, kernel.footprint.half.y)) + 8;
      std::mt19937 random(5);
      std::uniform_real_distribution<double> within(0.001, 0.999);
      for (int trial = 0; trial < 20; ++trial) {
        const double x = n / 2 + 0.5 + within(random), y = n / 2 + 0.5 + within(random);
        const auto at_phase = [&](double position) {
          const double offset = position - 0.5 - std::floor(position - 0.5);
          return position - offset + (std::floor(offset * known) + 0.5) / known;
        };
        const double phase_x = at_phase(x), phase_y = at_phase(y);
        CHECK(std::abs(phase_x - x) <= 0.5 / known + 1e-12);
        const auto tile = kernel_alone(kernel, x, y, n);
        double worst = 0;
        for (int j = 0; j < n; ++j)
          for (int i = 0; i < n; ++i) {
            const double expected =
                quartic(direct_q(kernel.footprint, {i + 0.5 - phase_x, j + 0.5 - phase_y}));
            worst = std::max(worst, std::abs(double(tile[std::size_t(4 * (j * n + i))]) - expected));
          }
        INFO(fmt::format("{} pixels a voxel, {} phases, ({}, {})", lattice.scale, phases, x, y));
        REQUIRE(worst < 1e-6);
      }
    }
}

TEST_CASE("a table is kept below 16 MiB by fewer phases", "[kernels]") {
  const auto wide = make_footprint_table(footprint_of({300, 0, 1, 0, 1}), 16);
  CHECK(wide.phases >= 1);
  CHECK(wide.phases < 16);
  CHECK(wide.weights.size() <= std::size_t{4} << 20);
  CHECK(make_footprint_table(footprint_of({600, 0, 1, 0, 1}), 16).phases == 1);
  CHECK(make_footprint_table(footprint_of({4, 0, 1, 0, 1}), 16).phases == 16);
}

TEST_CASE("fixed point cuts Q to a multiple of its last place, from below", "[kernels]") {
  for (const auto& lattice : lattices)
    for (const int bits : {4, 10, 16}) {
      const auto kernel = kernel_of(lattice, {.qee_bits = bits});
      const int n = 2 * int(std::max(kernel.footprint.half.x, kernel.footprint.half.y)) + 8;
      const double last_place = std::ldexp(1.0, -bits);
      std::mt19937 random(6);
      std::uniform_real_distribution<double> within(0, 1);
      double lowest = 0, highest = -1;
      for (int trial = 0; trial < 20; ++trial) {
        const double x = n / 2 + 0.5 + within(random), y = n / 2 + 0.5 + within(random);
        const auto tile = kernel_alone(kernel, x, y, n);
        for (int j = 0; j < n; ++j)
          for (int i = 0; i < n; ++i) {
            const double q = direct_q(kernel.footprint, {i + 0.5 - x, j + 0.5 - y});
            const double drawn = std::sqrt(double(tile[std::size_t(4 * (j * n + i))]));
            if (!(drawn > 0)) {
              REQUIRE(q < last_place * 1.6);
              continue;
            }
            REQUIRE(drawn / last_place == Approx(std::round(drawn / last_place)).epsilon(1e-5));
            lowest = std::min(lowest, (drawn - q) / last_place);
            highest = std::max(highest, (drawn - q) / last_place);
          }
      }
      INFO(fmt::format("{} pixels a voxel, {} bits: {} to {} last places", lattice.scale, bits, lowest,
                       highest));
      CHECK(lowest > -1.6);
      CHECK(lowest < -0.5);  // it is cut, not rounded
      CHECK(highest < 0.6);
    }
}

TEST_CASE("every kernel draws the same bits in regions of any size", "[kernels]") {
  constexpr int size = 160;
  for (const auto& lattice : lattices)
    for (const auto& options : kernels) {
      const auto kernel = kernel_of(lattice, options);
      std::vector<std::vector<Placed>> slices;
      for (unsigned z = 0; z < 2; ++z)
        slices.push_back(random_splats(kernel.footprint, 300, -20, -20, size + 20, size + 20, z));
      const auto whole = paint(kernel, slices, 0, 0, size, size);
      REQUIRE(*std::max_element(whole.begin(), whole.end()) > 1e-4F);
      for (const int part : {64, 37})
        for (int y0 = 0; y0 < size; y0 += part)
          for (int x0 = 0; x0 < size; x0 += part) {
            const int width = std::min(part, size - x0), height = std::min(part, size - y0);
            const auto tile = paint(kernel, slices, x0, y0, width, height);
            for (int y = 0; y < height; ++y) {
              const auto row = whole.begin() + 4 * ((y0 + y) * size + x0);
              REQUIRE(std::equal(row, row + 4 * width, tile.begin() + 4 * y * width));
            }
          }
    }
}

TEST_CASE("every instruction set draws the same bits from a table, and normalises alike",
          "[kernels][vector]") {
  constexpr int width = 83, height = 61;
  for (const auto& lattice : lattices) {
    const auto kernel =
        kernel_of(lattice, {.method = KernelMethod::texture, .normalisation = Normalisation::exact});
    const std::vector<std::vector<Placed>> slices{
        random_splats(kernel.footprint, 300, -9, -9, width + 9, height + 9, 1)};
    use_vector_target("");
    const auto expected = paint(kernel, slices, 0, 0, width, height);
    for (const auto& target : vector_targets()) {
      use_vector_target(target);
      INFO(target << ", " << lattice.scale << " pixels a voxel");
      CHECK(same_bits(paint(kernel, slices, 0, 0, width, height), expected));
    }
    use_vector_target("");
  }
}

TEST_CASE("one painter takes frame after frame with other kernels", "[kernels]") {
  RegionPainter used(0, 0, 50, 40);
  for (const auto& lattice : lattices)
    for (const auto& options : kernels) {
      const auto kernel = kernel_of(lattice, options);
      const auto splats = random_splats(kernel.footprint, 60, -5, -5, 55, 45, 2);
      used.begin_frame(kernel);
      draw_all(used, splats);
      used.composite(voxel);
      CHECK(same_bits(tile_of(used, 50, 40), paint(kernel, {splats}, 0, 0, 50, 40)));
      draw_all(used, random_splats(kernel.footprint, 60, -5, -5, 55, 45, 3));  // left in the slice buffer
    }
}

TEST_CASE("no bytes from outside can break a picture of other kernels", "[kernels][fuzz]") {
  std::mt19937 random(17);
  std::uniform_int_distribution<int> byte(0, 255), size(1, 70), base(-300, 300);
  for (const auto& lattice : lattices)
    for (const auto& options : kernels) {
      const auto kernel = kernel_of(lattice, options);
      for (int round = 0; round < 10; ++round) {
        const int width = size(random), height = size(random);
        RegionPainter painter(0, 0, width, height);
        painter.begin_frame(kernel);
        Bytes bytes(200 * sizeof(Splat));
        for (auto& value : bytes) value = static_cast<std::byte>(byte(random));
        const auto counts = painter.draw(base(random), base(random), bytes);
        CHECK(counts.drawn + counts.clipped == 200);
        painter.composite(voxel);
        for (const float value : tile_of(painter, width, height)) REQUIRE((value >= 0 && value <= 1.0001F));
      }
      RegionPainter painter(0, 0, 32, 32);
      painter.begin_frame(kernel);
      const auto good = make_splat(kernel.footprint, 0.5, 0.5, 1, 1, 1, 1);
      for (const float value :
           {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
            -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::max()})
        for (const auto word : {&Splat::a, &Splat::b, &Splat::c, &Splat::opacity}) {
          auto bad = good;
          bad.*word = value;
          CHECK(painter.draw(16, 16, bytes_of(bad)).clipped == 1);
        }
      CHECK(painter.draw(16, 16, bytes_of(good)).drawn == 1);
    }
}

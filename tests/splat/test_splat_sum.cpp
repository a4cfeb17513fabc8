#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "splat/reference_painter.hpp"
#include "splat/scene.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Lattice lattices[] = {{0.1, 0.4, 0.7, 0.9, 1}, {1.17, 0, 1, 0, 1},      {1.17, 0.4, 0.58, 0.9, 1},
                            {1.6, 0.2, 0.8, 0.1, 1}, {4.7, 0.4, 0.7, 0.9, 1}, {12, 1.4, 0.58, 0.2, 0.5},
                            {150, 0.4, 0.7, 0.9, 1}};

bool is_transparent(const std::vector<float>& tile) {
  return std::all_of(tile.begin(), tile.end(), [](float value) { return value == 0; });
}

}  // namespace

TEST_CASE("one splat is exactly the quartic", "[painter]") {
  const auto footprint = footprint_of(GENERATE(from_range(std::begin(lattices), std::end(lattices))));
  const Material material{0.25F, 0.5F, 1.0F, 0.7F};
  const auto placed = place(footprint, 20.3, 15.9, material);
  RegionPainter painter(0, 0, 40, 32);
  painter.begin_frame(footprint);
  const auto counts = painter.draw({&placed.splat, 1});
  CHECK(counts.drawn == 1);
  CHECK(counts.clipped == 0);
  painter.composite();
  const auto tile = tile_of(painter, 40, 32);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double weight =
          quartic(direct_q(footprint, {x + 0.5 - 20.3, y + 0.5 - 15.9})) * 0.7 * footprint.weight;
      const float* pixel = tile.data() + 4 * (y * 40 + x);
      CHECK(static_cast<double>(pixel[0]) == Approx(0.25 * weight).margin(3e-6));
      CHECK(static_cast<double>(pixel[1]) == Approx(0.5 * weight).margin(3e-6));
      CHECK(static_cast<double>(pixel[2]) == Approx(weight).margin(3e-6));
      CHECK(static_cast<double>(pixel[3]) == Approx(weight).margin(3e-6));
    }
  }
}

TEST_CASE("512 composited slices stay at the double-precision image", "[painter]") {
  const auto footprint = footprint_of({1.17, 0.4, 0.7, 0.9, 1});
  constexpr int width = 24, height = 20;
  RegionPainter painter(0, 0, width, height);
  DoublePainter reference(footprint, width, height);
  painter.begin_frame(footprint);
  for (unsigned z = 0; z < 512; ++z) {
    const auto slice = random_splats(footprint, 120, -3, -3, width + 3, height + 3, z, 0.02F);
    draw_all(painter, slice);
    for (const auto& placed : slice) reference.draw(placed);
    painter.composite();
    reference.composite();
  }
  const auto tile = tile_of(painter, width, height);
  CHECK(reference.error(tile) < 2e-5);
  CHECK(*std::max_element(tile.begin(), tile.end()) > 0.5F);
}

TEST_CASE("a slice's sum is clamped before it is composited", "[painter]") {
  const auto footprint = footprint_of({1.17, 0, 1, 0, 1});
  RegionPainter painter(0, 0, 16, 16);
  DoublePainter reference(footprint, 16, 16);
  painter.begin_frame(footprint);
  for (unsigned z = 0; z < 3; ++z) {
    const auto slice = random_splats(footprint, 400, 0, 0, 16, 16, z, 1);
    draw_all(painter, slice);
    for (const auto& placed : slice) reference.draw(placed);
    painter.composite();
    reference.composite();
  }
  const auto tile = tile_of(painter, 16, 16);
  CHECK(reference.error(tile) < 1e-5);
  for (std::size_t i = 0; i < tile.size(); i += 4) {
    REQUIRE(tile[i + 3] <= 1);
    REQUIRE(*std::max_element(tile.begin() + static_cast<std::ptrdiff_t>(i),
                              tile.begin() + static_cast<std::ptrdiff_t>(i + 3)) <= tile[i + 3] + 1e-6F);
  }
}

TEST_CASE("regions of any size show the same bits", "[painter]") {
  const auto footprint = footprint_of(GENERATE(from_range(std::begin(lattices), std::end(lattices))));
  constexpr int size = 512, slices = 2;
  const int part = GENERATE(128, 100, 37);
  std::vector<std::vector<Placed>> scene;
  for (unsigned z = 0; z < slices; ++z)
    scene.push_back(random_splats(footprint, 600, -20, -20, size + 20, size + 20, z));
  const auto paint = [&](RegionPainter& painter) {
    painter.begin_frame(footprint);
    for (const auto& slice : scene) {
      draw_all(painter, slice);
      painter.composite();
    }
  };
  RegionPainter whole(0, 0, size, size);
  paint(whole);
  const auto picture = tile_of(whole, size, size);
  CHECK_FALSE(is_transparent(picture));
  for (int y0 = 0; y0 < size; y0 += part) {
    for (int x0 = 0; x0 < size; x0 += part) {
      const int width = std::min(part, size - x0), height = std::min(part, size - y0);
      RegionPainter painter(x0, y0, width, height);
      paint(painter);
      const auto tile = tile_of(painter, width, height);
      for (int y = 0; y < height; ++y) {
        const auto row = picture.begin() + 4 * ((y0 + y) * size + x0);
        REQUIRE(std::equal(row, row + 4 * width, tile.begin() + 4 * y * width));
      }
    }
  }
}

TEST_CASE("drawn and clipped tell which splats reach a pixel centre", "[painter]") {
  const auto footprint = footprint_of(GENERATE(from_range(std::begin(lattices), std::end(lattices))));
  constexpr int width = 30, height = 21;
  const double beyond = 1.5 * std::max(footprint.half.x, footprint.half.y);
  RegionPainter painter(0, 0, width, height);
  painter.begin_frame(footprint);
  DoublePainter reference(footprint, width, height);
  int drawn = 0, clipped = 0;
  for (const auto& placed :
       random_splats(footprint, 2000, -beyond, -beyond, width + beyond, height + beyond, 4)) {
    const auto counts = draw_all(painter, {placed});
    REQUIRE(counts.drawn + counts.clipped == 1);
    // Where Q is 0 to float precision either answer is right.
    const bool surely = reference.draw(placed, 1e-5), perhaps = reference.draw(placed, -1e-5);
    if (surely) REQUIRE(counts.drawn == 1);
    if (!perhaps) REQUIRE(counts.drawn == 0);
    drawn += surely;
    clipped += !perhaps;
  }
  CHECK(drawn > 200);
  CHECK(clipped > 200);
}

TEST_CASE("a region that nothing reached is transparent", "[painter]") {
  const auto footprint = footprint_of({1.17, 0, 1, 0, 1});
  RegionPainter painter(256, 128, 64, 64);
  CHECK_FALSE(painter.touched());
  CHECK(is_transparent(tile_of(painter, 64, 64)));
  painter.begin_frame(footprint);
  painter.composite();
  CHECK_FALSE(painter.touched());
  const auto counts = draw_all(painter, random_splats(footprint, 20, 0, 0, 200, 100, 1));
  CHECK(counts.drawn == 0);
  CHECK(counts.clipped == 20);
  painter.composite();
  CHECK_FALSE(painter.touched());
  CHECK(is_transparent(tile_of(painter, 64, 64)));
  CHECK(painter.draw({}).clipped == 0);
}

TEST_CASE("nothing of a frame is left in the next one", "[painter]") {
  const auto first = footprint_of(GENERATE(from_range(std::begin(lattices), std::end(lattices))));
  const auto second = footprint_of(GENERATE(from_range(std::begin(lattices), std::end(lattices))));
  const bool finished = GENERATE(true, false);
  const auto after = random_splats(second, 60, 0, 0, 50, 40, 2);
  RegionPainter used(0, 0, 50, 40), fresh(0, 0, 50, 40);
  used.begin_frame(first);
  draw_all(used, random_splats(first, 60, -5, -5, 55, 45, 1));
  if (finished) used.composite();
  for (auto* painter : {&used, &fresh}) {
    painter->begin_frame(second);
    CHECK_FALSE(painter->touched());
    draw_all(*painter, after);
    painter->composite();
    CHECK(painter->touched());
  }
  CHECK(same_bits(tile_of(used, 50, 40), tile_of(fresh, 50, 40)));
}

TEST_CASE("compositing twice is compositing once", "[painter]") {
  const auto footprint = footprint_of({1.17, 0, 1, 0, 1});
  RegionPainter painter(0, 0, 32, 32);
  painter.begin_frame(footprint);
  draw_all(painter, random_splats(footprint, 100, 0, 0, 32, 32, 1));
  painter.composite();
  const auto tile = tile_of(painter, 32, 32);
  painter.composite();
  CHECK(same_bits(tile_of(painter, 32, 32), tile));
}

TEST_CASE("kernels of thousands of pixels far off the screen reach it", "[painter]") {
  const double scale = GENERATE(700.0, 19000.0, 1e7);
  const auto footprint = footprint_of({scale, 0.4, 0.7, 0.9, 1});
  constexpr int width = 40, height = 30;
  RegionPainter painter(0, 0, width, height);
  DoublePainter reference(footprint, width, height);
  painter.begin_frame(footprint);
  const double far = 0.5 * scale;
  std::uint64_t drawn = 0;
  for (unsigned z = 0; z < 4; ++z) {
    const auto slice = random_splats(footprint, 10, -far, -far, far, far, z, 0.5F);
    drawn += draw_all(painter, slice).drawn;
    for (const auto& placed : slice) reference.draw(placed);
    painter.composite();
    reference.composite();
  }
  CHECK(drawn > 10);
  CHECK(reference.error(tile_of(painter, width, height)) < 2e-6);
}

TEST_CASE("anchors at the ends of their range are clipped", "[painter]") {
  const auto footprint = footprint_of(GENERATE(from_range(std::begin(lattices), std::end(lattices))));
  const std::int64_t edges[] = {anchor_pixel(-1e300), -(1 << 30), 1 << 30, anchor_pixel(1e300)};
  const auto corner = GENERATE(0, (1 << 20) - 64);
  RegionPainter painter(corner, corner, 64, 64);
  painter.begin_frame(footprint);
  const auto clipped = [&](std::int64_t x, std::int64_t y) {
    const auto splat = make_splat(footprint, {x, y, 0.5, 0.5}, {65535, 65535, 65535, 1});
    return painter.draw({&splat, 1}).clipped == 1;
  };
  for (const auto x : edges) {
    for (const auto y : edges) CHECK(clipped(x, y));
    CHECK(clipped(x, corner));
    CHECK(clipped(corner, x));
  }
  CHECK_FALSE(painter.touched());
}

TEST_CASE("infinite and undefined coefficients are clipped", "[painter][fuzz]") {
  const auto footprint = footprint_of({1.17, 0, 1, 0, 1});
  RegionPainter painter(0, 0, 32, 32);
  painter.begin_frame(footprint);
  const auto good = make_splat(footprint, {16, 16, 0.5, 0.5}, {65535, 65535, 65535, 1});
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::max()}) {
    for (const auto word : {&Splat::a, &Splat::b, &Splat::c, &Splat::opacity}) {
      auto bad = good;
      bad.*word = value;
      CHECK(painter.draw({&bad, 1}).clipped == 1);
    }
  }
  CHECK_FALSE(painter.touched());
  CHECK(painter.draw({&good, 1}).drawn == 1);
}

#include "ringsplat/volume/reduced.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "volume/forwarding_source.hpp"

using namespace ringsplat;

namespace {

Grid float_grid(glm::ivec3 dims) {
  Grid grid;
  grid.dims = dims;
  grid.spacing = {1, 2, 3};
  grid.origin = {10, 20, 30};
  grid.type = ScalarType::float32;
  return grid;
}

std::vector<float> reduced(const Grid& grid, const std::vector<float>& values, const Reduction& reduction) {
  const auto full = memory_source(grid, std::as_bytes(std::span(values)));
  const auto source = reduced_source(*full, reduction);
  std::vector<float> out(std::size_t(source->grid().voxels()));
  source->read_slices(0, source->grid().dims.z, std::as_writable_bytes(std::span(out)));
  return out;
}

}  // namespace

TEST_CASE("a reduced lattice covers the volume, and means lie in the middle of their voxels") {
  const Grid grid = float_grid({5, 4, 1});
  const Grid skipped = reduced_grid(grid, {2, false}), mean = reduced_grid(grid, {2, true});
  CHECK(skipped.dims == glm::ivec3(3, 2, 1));
  CHECK(skipped.spacing == glm::dvec3(2, 4, 6));
  CHECK(skipped.origin == grid.origin);
  CHECK(mean.origin == glm::dvec3(10.5, 21, 31.5));
  CHECK(reduced_grid(grid, {1, true}).dims == grid.dims);
  CHECK_THROWS_AS(reduced_grid(grid, {0, false}), InputError);
}

TEST_CASE("a prefiltered lattice begins at the volume's own corner, however it lies in the world") {
  Grid grid = float_grid({8, 6, 4});
  grid.direction = {glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0.3, 0, 0.9)};
  const auto corner = [](const Grid& g) { return g.origin - g.direction * (0.5 * g.spacing); };
  for (const int factor : {2, 4}) {
    const Grid mean = reduced_grid(grid, {factor, true});
    CHECK(mean.direction == grid.direction);
    for (int k = 0; k < 3; ++k) CHECK(corner(mean)[k] == Approx(corner(grid)[k]).margin(1e-12));
  }
}

TEST_CASE("skipping takes every second voxel") {
  const Grid grid = float_grid({5, 3, 3});
  std::vector<float> values(45);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = float(k);
  const auto picked = reduced(grid, values, {2, false});
  CHECK(picked == std::vector<float>{0, 2, 4, 10, 12, 14, 30, 32, 34, 40, 42, 44});
}

TEST_CASE("prefiltering keeps a cubic field inside the volume, and a mean would not") {
  const Grid grid = float_grid({24, 20, 22});
  const auto field = [](double x, double y, double z) {
    return 5 + x - 0.3 * y * y + 0.002 * x * x * x + 0.04 * x * y - 0.1 * z * z * z + 2 * z;
  };
  std::vector<float> values;
  for (int z = 0; z < 22; ++z)
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 24; ++x) values.push_back(float(field(x, y, z)));
  for (const int factor : {2, 4}) {
    const auto filtered = reduced(grid, values, {factor, true});
    const glm::ivec3 dims = reduced_grid(grid, {factor, true}).dims;
    const double middle = 0.5 * (factor - 1);
    for (int z = 1; z < dims.z - 2; ++z)
      for (int y = 1; y < dims.y - 1; ++y)
        for (int x = 1; x < dims.x - 1; ++x) {
          const double expected = field(factor * x + middle, factor * y + middle, factor * z + middle);
          REQUIRE(double(filtered[std::size_t(x + dims.x * (y + dims.y * z))]) ==
                  Approx(expected).epsilon(1e-5).margin(1e-3));
        }
  }
}

TEST_CASE("a prefiltered voxel lies within the range of those it stands for") {
  const Grid grid = float_grid({9, 8, 8});
  std::vector<float> values(9 * 8 * 8);
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = k % 9 < 4 ? 0.0F : 1.0F;  // an edge between two cells
  for (const float value : reduced(grid, values, {2, true})) CHECK((value == 0 || value == 1));
  // A single bright voxel at the end is all that its cell has.
  values.assign(values.size(), 0.25F);
  values.back() = 8;
  const auto filtered = reduced(grid, values, {2, true});
  CHECK(filtered.back() > 0.25F);
  CHECK(filtered.back() <= 8);
}

TEST_CASE("where not-a-number is near a prefiltered voxel is the mean of its numbers") {
  const Grid grid = float_grid({5, 3, 3});
  std::vector<float> values(45);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = float(k);
  values[1] = std::numeric_limits<float>::quiet_NaN();
  const auto filtered = reduced(grid, values, {2, true});
  CHECK(filtered[0] == Approx((0 + 5 + 6 + 15 + 16 + 20 + 21) / 7.0));
  CHECK(filtered[1] == Approx((2 + 3 + 7 + 8 + 17 + 18 + 22 + 23) / 8.0));
  CHECK(filtered.back() == 44);
  CHECK(std::isnan(reduced(grid, std::vector<float>(45, values[1]), {4, true})[0]));
}

TEST_CASE("voxels without data, by the fill value, take no part in a prefiltered one") {
  const auto grid = float_grid({4, 2, 2});
  const std::vector<float> values{1, -9999, -9999, -9999, 3, 5, -9999, -9999,
                                  1, 1,     -9999, -9999, 1, 2, -9999, -9999};
  const auto full = with_notes(memory_source(grid, std::as_bytes(std::span(values))), {.fill = -9999.0});
  std::vector<float> out(2);
  reduced_source(*full, {2, true})->read_slices(0, 1, std::as_writable_bytes(std::span(out)));
  CHECK(out[0] == Approx(14 / 7.0));
  CHECK(out[1] == -9999);
}

TEST_CASE("prefiltered integers are rounded to the nearest and do not wrap") {
  Grid grid = float_grid({4, 1, 1});
  grid.type = ScalarType::int16;
  const std::vector<std::int16_t> values{-32768, -32765, 32767, 32766};
  const auto full = memory_source(grid, std::as_bytes(std::span(values)));
  std::array<std::int16_t, 2> filtered{};
  reduced_source(*full, {2, true})->read_slices(0, 1, std::as_writable_bytes(std::span(filtered)));
  // The taps reach -32768 · 8/16 − 32765 · 9/16 − 32767/16 and its like; the cells end at their own voxels.
  CHECK(filtered[0] == -32768);
  CHECK(filtered[1] == 32767);
}

TEST_CASE("slices may be read in pieces, from anywhere") {
  const Grid grid = float_grid({6, 6, 19});
  std::vector<float> values(6 * 6 * 19);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = float((k * 37) % 101);
  for (const int factor : {2, 4}) {
    const auto whole = reduced(grid, values, {factor, true});
    const auto full = memory_source(grid, std::as_bytes(std::span(values)));
    const auto source = reduced_source(*full, {factor, true});
    const std::size_t slice = source->grid().slice_voxels(Axis::z);
    std::vector<float> out(slice);
    for (const int z : {3, 4, 0, 1, 4}) {
      source->read_slices(z, 1, std::as_writable_bytes(std::span(out)));
      CHECK(std::equal(out.begin(), out.end(), whole.begin() + std::ptrdiff_t(std::size_t(z) * slice)));
    }
  }
}

TEST_CASE(
    "a box of a reduced volume has the voxels that lie in the box, never none, and all of a whole one") {
  Grid grid;
  grid.dims = {17, 16, 5};
  for (const int factor : {2, 4})
    for (const bool prefilter : {false, true}) {
      const Reduction reduction{factor, prefilter};
      const glm::ivec3 dims = reduced_grid(grid, reduction).dims;
      CHECK(reduced_box(whole_box(grid), grid, reduction) == VoxelBox{glm::ivec3(0), dims});
      for (int k = 0; k < 3; ++k)
        for (int first = 0; first < grid.dims[k]; ++first)
          for (int end = first + 1; end <= grid.dims[k]; ++end) {
            INFO("factor " << factor << " prefilter " << prefilter << ' ' << first << ':' << end);
            VoxelBox box = whole_box(grid);
            box.first[k] = first;
            box.end[k] = end;
            const VoxelBox reduced = reduced_box(box, grid, reduction);
            REQUIRE(reduced.first[k] >= 0);
            REQUIRE(reduced.first[k] < reduced.end[k]);
            REQUIRE(reduced.end[k] <= dims[k]);
            int inside = 0;
            for (int i = 0; i < dims[k]; ++i) {
              const double place = factor * i + (prefilter ? 0.5 * (factor - 1) : 0.0);
              const bool lies_in = place >= first - 0.5 && place < end - 0.5;
              const bool at_face = (first == 0 && place < first) || (end == grid.dims[k] && place > end - 1);
              const bool taken = i >= reduced.first[k] && i < reduced.end[k];
              inside += lies_in;
              if (lies_in) CHECK(taken);
              if (taken && inside > 0) CHECK((lies_in || at_face));
            }
            if (inside == 0) {
              REQUIRE(reduced.end[k] - reduced.first[k] == 1);
              const auto from_middle = [&](int i) {
                return std::abs(factor * i + (prefilter ? 0.5 * (factor - 1) : 0.0) -
                                0.5 * (first + end - 1));
              };
              for (int i = 0; i < dims[k]; ++i) CHECK(from_middle(reduced.first[k]) <= from_middle(i));
            }
          }
    }
}

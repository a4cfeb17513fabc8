#include "ringsplat/volume/reduced.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

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

TEST_CASE("skipping takes every second voxel, prefiltering the mean of eight, without not-a-number") {
  const Grid grid = float_grid({5, 3, 3});
  std::vector<float> values(45);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = float(k);
  const auto picked = reduced(grid, values, {2, false});
  CHECK(picked == std::vector<float>{0, 2, 4, 10, 12, 14, 30, 32, 34, 40, 42, 44});
  values[1] = std::numeric_limits<float>::quiet_NaN();
  const auto means = reduced(grid, values, {2, true});
  CHECK(means[0] == Approx((0 + 5 + 6 + 15 + 16 + 20 + 21) / 7.0));
  CHECK(means[1] == Approx((2 + 3 + 7 + 8 + 17 + 18 + 22 + 23) / 8.0));
  CHECK(means[2] == Approx((4 + 9 + 19 + 24) / 4.0));
  CHECK(means.back() == 44);
  CHECK(std::isnan(reduced(grid, std::vector<float>(45, values[1]), {4, true})[0]));
}

TEST_CASE("means of integers are rounded to the nearest") {
  Grid grid = float_grid({2, 1, 1});
  grid.type = ScalarType::int16;
  const std::vector<std::int16_t> values{-32768, -32765};
  const auto full = memory_source(grid, std::as_bytes(std::span(values)));
  std::int16_t mean = 0;
  reduced_source(*full, {2, true})->read_slices(0, 1, std::as_writable_bytes(std::span(&mean, 1)));
  CHECK((mean == -32766 || mean == -32767));
}

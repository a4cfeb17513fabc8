#include <cmath>
#include <limits>

#include "ringsplat/volume/grid.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

TEST_CASE("scalar types have names, sizes and aliases", "[grid]") {
  const std::pair<ScalarType, std::size_t> sizes[] = {
      {ScalarType::int8, 1},  {ScalarType::uint8, 1},  {ScalarType::int16, 2},   {ScalarType::uint16, 2},
      {ScalarType::int32, 4}, {ScalarType::uint32, 4}, {ScalarType::float32, 4}, {ScalarType::float64, 8}};
  for (const auto& [type, size] : sizes) {
    CHECK(size_of(type) == size);
    CHECK(scalar_type_from(to_string(type)) == type);
  }
  CHECK(scalar_type_from("unsigned char") == ScalarType::uint8);
  CHECK(scalar_type_from("Float") == ScalarType::float32);
  CHECK(scalar_type_from("u16") == ScalarType::uint16);
  const auto complaint = message_of([] { scalar_type_from("int64"); });
  CHECK(says(complaint, "int64"));
  CHECK(says(complaint, "float64"));
}

TEST_CASE("slices of each axis have the other two axes' size", "[grid]") {
  Grid grid;
  grid.dims = {7, 5, 3};
  grid.type = ScalarType::int16;
  CHECK(grid.slice_width(Axis::x) == 5);
  CHECK(grid.slice_height(Axis::x) == 3);
  CHECK(grid.slice_width(Axis::y) == 7);
  CHECK(grid.slice_height(Axis::y) == 3);
  CHECK(grid.slice_bytes(Axis::z) == 70);
  CHECK(grid.bytes() == 210);
}

TEST_CASE("a grid that cannot be rendered is refused with the place named", "[grid]") {
  Grid good;
  good.dims = {2, 3, 4};
  CHECK_NOTHROW(check(good, "here"));
  const auto refused = [&](auto change) {
    Grid grid = good;
    change(grid);
    CHECK(says(message_of([&] { check(grid, "here"); }), "here"));
  };
  refused([](Grid& g) { g.dims.y = 0; });
  refused([](Grid& g) { g.dims.z = -4; });
  refused([](Grid& g) { g.dims = glm::ivec3(std::numeric_limits<int>::max()); });
  refused([](Grid& g) { g.spacing.x = 0; });
  refused([](Grid& g) { g.spacing.x = -1; });
  refused([](Grid& g) { g.spacing.z = std::numeric_limits<double>::quiet_NaN(); });
  refused([](Grid& g) { g.spacing.z = 4.8e228; });
  refused([](Grid& g) { g.spacing = glm::dvec3(1e-310); });
  refused([](Grid& g) { g.spacing = glm::dvec3(1e308); });
  for (const double scale : {1e-100, 1e-15, 1e24, 1e100}) {
    good.spacing = scale * glm::dvec3(1, 1, 1e5);
    CHECK_NOTHROW(check(good, "here"));
  }
  refused([](Grid& g) { g.origin.z = std::numeric_limits<double>::infinity(); });
  refused([](Grid& g) { g.direction[1] = g.direction[0]; });
  refused([](Grid& g) { g.direction[1] = glm::dvec3(std::numeric_limits<double>::quiet_NaN()); });
}

TEST_CASE("a shear is judged by its angles, whatever the columns' lengths", "[grid]") {
  const auto direction = [](const glm::dvec3& lengths, double rise) {
    return glm::dmat3(lengths.x * glm::dvec3(1, 0, 0), lengths.y * glm::dvec3(0, 1, 0),
                      lengths.z * glm::dvec3(std::sqrt(1 - rise * rise), 0, rise));
  };
  for (const glm::dvec3& lengths :
       {glm::dvec3(1.0), glm::dvec3(0.01, 0.01, 1), glm::dvec3(100, 100, 1), glm::dvec3(1, 1e-2, 1e3)}) {
    Grid grid;
    grid.dims = {2, 3, 4};
    grid.direction = direction(lengths, 0.002);
    CHECK_NOTHROW(check(grid, "here"));
    grid.direction = direction(lengths, 0.0005);
    CHECK(says(message_of([&] { check(grid, "here"); }), "singular"));
  }
}

TEST_CASE("volumes beyond 2^31 voxels are counted in 64 bits", "[grid]") {
  Grid grid;
  grid.dims = {4096, 4096, 4096};
  grid.type = ScalarType::float32;
  CHECK_NOTHROW(check(grid, "large"));
  CHECK(grid.bytes() == std::uint64_t{1} << 38);
}

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <set>

#include "ringsplat/base/error.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "volume/synth.hpp"

using namespace ringsplat;

namespace {
Grid grid_of(glm::ivec3 dims, ScalarType type) {
  Grid grid;
  grid.dims = dims;
  grid.type = type;
  return grid;
}

template <class T>
std::vector<T> read(VolumeSource& source) {
  std::vector<T> values(std::size_t(source.grid().voxels()));
  source.read_slices(0, source.grid().dims.z, std::as_writable_bytes(std::span(values)));
  return values;
}
}  // namespace

TEST_CASE("every analytic volume stays in [0, 1], is not constant but for 'constant', and is described",
          "[synth]") {
  std::set<std::string> names;
  for (const auto& [text, description, field] : synth_names()) {
    const std::string name = text;
    CAPTURE(name);
    CHECK(std::string(description) != "");
    names.insert(name);
    const auto source = synth_source(name, grid_of({20, 24, 28}, ScalarType::float64));
    CHECK(source->concurrent());
    const auto values = read<double>(*source);
    ValueRange range;
    range.add(ScalarType::float64, std::as_bytes(std::span(values)));
    CHECK(range.low >= 0);
    CHECK(range.high <= 1);
    CHECK((range.high > range.low) == (name != "constant"));
  }
  for (const char* wanted :
       {"constant", "slab", "ball", "box", "shell", "gaussians", "marschner-lobb", "ramp", "jack", "point"})
    CHECK(names.count(wanted) == 1);
}

TEST_CASE("voxel centres are half a voxel inside the cube", "[synth]") {
  const auto source = synth_source("ramp", grid_of({4, 2, 2}, ScalarType::float64));
  const auto values = read<double>(*source);
  CHECK(values[0] == 0.125);
  CHECK(values[3] == 0.875);
}

TEST_CASE("integer types use their positive range", "[synth]") {
  CHECK(read<std::uint8_t>(*synth_source("constant", grid_of({2, 1, 1}, ScalarType::uint8)))[0] == 255);
  CHECK(read<std::int16_t>(*synth_source("constant", grid_of({2, 1, 1}, ScalarType::int16)))[0] == 32767);
  CHECK(read<std::uint32_t>(*synth_source("constant", grid_of({2, 1, 1}, ScalarType::uint32)))[0] ==
        std::numeric_limits<std::uint32_t>::max());
}

TEST_CASE("Marschner and Lobb's signal has its published values", "[synth]") {
  const auto f = synth_field("marschner-lobb");
  // On the axis r = 0: cos(2 pi 6) = 1, so rho = (1 - sin(pi z / 2) + 0.5) / 2.5.
  CHECK(f(0.5, 0.5, 0.5) == Approx(0.6));
  CHECK(f(0.5, 0.5, 1.0) == Approx(0.2));
  CHECK(f(0.5, 0.5, 0.0) == Approx(1.0));
  const double r = 0.4;
  const double ring = std::cos(2 * std::numbers::pi * 6 * std::cos(std::numbers::pi * r / 2));
  CHECK(f(0.7, 0.5, 0.5) == Approx((1 + 0.25 * (1 + ring)) / 2.5));
}

TEST_CASE("the point is one voxel of the lattice", "[synth]") {
  const auto values = read<float>(*synth_source("point", grid_of({5, 4, 3}, ScalarType::float32)));
  double sum = 0;
  for (const float v : values) sum += v;
  CHECK(sum == 1);
  CHECK(values[2 + 5 * (2 + 4 * 1)] == 1);
}

TEST_CASE("the jack differs from all its mirror images and turns", "[synth]") {
  const auto jack = synth_field("jack");
  CHECK(jack(0.88, 0.5, 0.5) == 1);
  CHECK(jack(0.12, 0.5, 0.5) == 0);
  CHECK(jack(0.5, 0.76, 0.5) == 1);
  CHECK(jack(0.5, 0.80, 0.5) == 0);
  CHECK(jack(0.5, 0.5, 0.66) == 1);
  CHECK(jack(0.5, 0.5, 0.76) == 0);
  CHECK(jack(0.15, 0.15, 0.2) == 1);
  CHECK(jack(0.3, 0.15, 0.41) == 1);
  CHECK(jack(0.3, 0.15, 0.15) == 0);
}

TEST_CASE("slices read one by one equal the whole, and slabs start where they say", "[synth]") {
  const auto source = synth_source("gaussians", grid_of({6, 5, 4}, ScalarType::uint16));
  const auto whole = read<std::uint16_t>(*source);
  for (int z = 0; z < 4; ++z) {
    std::vector<std::uint16_t> slice(30);
    source->read_slices(z, 1, std::as_writable_bytes(std::span(slice)));
    CHECK(std::memcmp(slice.data(), whole.data() + 30 * z, 60) == 0);
  }
}

TEST_CASE("unknown names list the known ones", "[synth]") {
  CHECK(says(message_of([] {
               synth_source("blob", grid_of({2, 2, 2}, ScalarType::uint8));
             }),
             "marschner-lobb"));
  CHECK_THROWS_AS(synth_field("point"), InputError);
  CHECK_THROWS_AS(synth_source("ball", grid_of({2, 0, 2}, ScalarType::uint8)), InputError);
}

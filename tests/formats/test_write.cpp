#include <algorithm>

#include "base/process.hpp"
#include "formats/files.hpp"
#include "formats/write.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "volume/synth.hpp"

using namespace files;

namespace {

Grid odd_grid(ScalarType type) {
  Grid grid;
  grid.dims = {7, 5, 6};
  grid.spacing = {0.1, 1.0 / 3, 2.75};
  grid.origin = {-12.3, 4e-5, 1e6};
  grid.direction = glm::dmat3(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1));
  grid.type = type;
  return grid;
}

double difference(const glm::dmat3& a, const glm::dmat3& b) {
  double most = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) most = std::max(most, std::abs(a[i][j] - b[i][j]));
  return most;
}

}  // namespace

TEST_CASE("what is written is read back, voxels and place in the world", "[write]") {
  const auto type = GENERATE(ScalarType::int8, ScalarType::uint8, ScalarType::int16, ScalarType::uint16,
                             ScalarType::int32, ScalarType::uint32, ScalarType::float32, ScalarType::float64);
  const auto name = GENERATE(as<std::string>(), "a.nrrd", "a.nhdr", "a.mhd");
  const bool compress = GENERATE(false, true);
  CAPTURE(to_string(type), name, compress);
  const Folder folder;
  const auto grid = odd_grid(type);
  const auto source = synth_source("gaussians", grid);
  CHECK(write_volume(*source, folder / name, compress) == folder / name);
  const auto back = open_volume(folder / name);
  CHECK(back->grid().dims == grid.dims);
  CHECK(back->grid().type == type);
  CHECK(difference(glm::dmat3(back->grid().spacing, back->grid().origin, glm::dvec3(0)),
                   glm::dmat3(grid.spacing, grid.origin, glm::dvec3(0))) < 1e-9);
  CHECK(difference(back->grid().direction, grid.direction) < 1e-12);
  CHECK(back->concurrent() == !(compress && name == "a.nrrd"));
  CHECK((read_all(*back) == read_all(*source)));
  CHECK(support::files_in(folder.path()) == (name == "a.nrrd" ? 1 : 2));
}

TEST_CASE("a raw file's name gets its size and type once", "[write]") {
  const Folder folder;
  const auto source = synth_source("ball", odd_grid(ScalarType::uint16));
  const auto written = write_volume(*source, folder / "ball.raw");
  CHECK(written == folder / "ball_7x5x6_uint16.raw");
  CHECK(write_volume(*source, written) == written);
  CHECK((read_all(*open_volume(written)) == read_all(*source)));
  CHECK(says(message_of([&] { write_volume(*source, folder / "ball_7x5x7_uint16.raw"); }), "7x5x7"));
}

TEST_CASE("what cannot be written is an error and leaves nothing behind", "[write]") {
  const Folder folder;
  const auto source = synth_source("ball", odd_grid(ScalarType::uint8));
  CHECK_THROWS_AS(write_volume(*source, folder / "ball.png"), InputError);
  CHECK_THROWS_AS(write_volume(*source, folder / "missing/ball.nrrd"), InputError);
  fs::create_directory(folder / "ball.nrrd");
  CHECK_THROWS_AS(write_volume(*source, folder / "ball.nrrd"), InputError);
  CHECK(support::files_in(folder.path()) == 1);
}

TEST_CASE("a source that fails half way leaves the old file alone", "[write]") {
  const Folder folder;
  write(folder / "old.nrrd", "precious");
  const auto data = gzip(samples<std::uint8_t>());
  const auto source = open_volume(write(folder / "cut.nrrd",
                                        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 5 4 3\n"
                                        "encoding: gzip\n\n" +
                                            data.substr(0, data.size() / 2)));
  CHECK_THROWS_AS(write_volume(*source, folder / "old.nrrd"), InputError);
  CHECK(slurp(folder / "old.nrrd") == "precious");
  CHECK(support::files_in(folder.path()) == 2);
}

TEST_CASE("a compressed volume is written and read without ever being held whole", "[write]") {
  const Folder folder;
  Grid grid;
  grid.dims = {512, 512, 256};
  const auto before = peak_memory_bytes();
  write_volume(*synth_source("constant", grid), folder / "large.nrrd", true);
  const auto source = open_volume(folder / "large.nrrd");
  std::vector<std::byte> slice(grid.slice_bytes(Axis::z));
  std::uint64_t full = 0;
  for (int z = 0; z < grid.dims.z; ++z) {
    source->read_slices(z, 1, slice);
    full += std::uint64_t(std::count(slice.begin(), slice.end(), std::byte{255}));
  }
  CHECK(full == std::uint64_t(grid.voxels()));
  CHECK(peak_memory_bytes() - before < grid.bytes() / 4);
}

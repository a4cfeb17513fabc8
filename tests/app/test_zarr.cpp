// A volume in chunks that all ranks decode has the picture of the same volume in one piece.
#include <fmt/format.h>

#include "app/workshop.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;

namespace {

constexpr int chunk = 24;

void describe_array(const fs::path& folder, const glm::ivec3& dims, int side) {
  write_text(
      folder / ".zarray",
      fmt::format(R"({{"zarr_format": 2, "shape": [{2}, {1}, {0}], "chunks": [{3}, {3}, {3}], "dtype": "|u1",
 "compressor": null, "fill_value": null, "order": "C", "filters": null}})",
                  dims.x, dims.y, dims.z, side));
}

/// Chunks of 24 voxels along each axis, filled up beyond the volume's ends.
void write_chunks(const fs::path& folder, const ringsplat::Grid& grid, const std::string& voxels) {
  const auto size = size_of(grid.type);
  const glm::ivec3 counts = (grid.dims + chunk - 1) / chunk;
  for (int n = 0; n < counts.x * counts.y * counts.z; ++n) {
    const glm::ivec3 at(n % counts.x, n / counts.x % counts.y, n / counts.x / counts.y);
    std::string values(chunk * chunk * chunk * size, 'x');
    for (int z = at.z * chunk; z < std::min((at.z + 1) * chunk, grid.dims.z); ++z)
      for (int y = at.y * chunk; y < std::min((at.y + 1) * chunk, grid.dims.y); ++y) {
        const int x = at.x * chunk, count = std::min(chunk, grid.dims.x - x);
        const auto from = (std::size_t(z) * grid.dims.y + y) * grid.dims.x + x,
                   to = std::size_t((z % chunk) * chunk + y % chunk) * chunk;
        values.replace(to * size, count * size, voxels, from * size, count * size);
      }
    write_text(folder / fmt::format("{}.{}.{}", at.z, at.y, at.x), values);
  }
  describe_array(folder, grid.dims, chunk);
}

}  // namespace

TEST_CASE("a head in chunks has the bytes of its picture on any ranks", "[mpi]") {
  const TemporaryFolder folder;
  const auto source = ringsplat::open_volume(fs::path(RINGSPLAT_TEST_DATA) / "head.nrrd");
  REQUIRE(source->grid().dims == glm::ivec3(128, 128, 124));
  // The picture's settings name the volume, so both have one name.
  const fs::path chunks = folder / "chunks/head.nrrd", file = folder / "file/head.nrrd";
  fs::create_directories(chunks);
  fs::create_directories(file.parent_path());
  std::string voxels(source->grid().bytes(), '\0');
  source->read_slices(0, source->grid().dims.z, std::as_writable_bytes(std::span(voxels)));
  write_chunks(chunks, source->grid(), voxels);
  write_text(file, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 128 128 124\nencoding: raw\n\n" + voxels);
  const auto picture = [&](const fs::path& volume, int ranks) {
    const std::string out = folder / "out.exr";
    succeeded(run_program({"render", volume.string(), "-o", out, "--size", "64", "--tf", "auto"}, ranks));
    return read_text(out);
  };
  for (const int ranks : {2, 3}) CHECK((picture(chunks, ranks) == picture(file, ranks)));
}

TEST_CASE("the far corner of a volume of 134 gigavoxels is read and drawn alone", "[mpi]") {
  const TemporaryFolder folder;
  const fs::path large = folder / "large.zarr", corner = folder / "corner_64x64x64_uint8.raw";
  fs::create_directories(large);
  describe_array(large, glm::ivec3(5120), 64);
  std::string voxels(64 * 64 * 64, '\0');
  for (std::size_t k = 0; k < voxels.size(); ++k) voxels[k] = char(k * 7 % 251 * (k % 64 > 20));
  write_text(large / "79.79.79", voxels);
  write_text(corner, voxels);
  const auto draw = [&](const fs::path& volume, std::vector<std::string> more) {
    more.insert(more.begin(), {"render", volume.string(), "-o", folder / (volume.stem().string() + ".exr"),
                               "--size", "96", "--tf", "grey"});
    const auto ended = run_program(more, 2);
    INFO(ended.err);
    CHECK(ended.code == 0);
  };
  draw(corner, {});
  draw(large, {"--crop", "5056:,5056:,5056:"});
  const std::string of_corner = folder / "corner_64x64x64_uint8.exr", of_large = folder / "large.exr";
  CHECK(run_program({"compare", of_large, of_corner, "--fail-above", "0"}).code == 0);
}

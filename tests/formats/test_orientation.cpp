#include <cmath>
#include <glm/geometric.hpp>

#include "formats/files.hpp"
#include "support/catch.hpp"

using namespace files;
using Catch::Matchers::Contains;

namespace {
void check_near(const glm::dvec3& got, const glm::dvec3& wanted) {
  CAPTURE(got.x, got.y, got.z, wanted.x, wanted.y, wanted.z);
  CHECK(glm::distance(got, wanted) < 1e-5);
}
}  // namespace

TEST_CASE("NIfTI's right-anterior-superior becomes left-posterior-superior", "[orientation]") {
  const Folder folder;
  Nifti file;
  const auto grid = open_volume(write(folder / "a.nii", file.header() + samples<short>()))->grid();
  CHECK(grid.spacing == glm::dvec3(1, 2, 3));
  check_near(grid.origin, {10, 20, -30});
  check_near(world(grid, {4, 3, 2}), {10 - 4, 20 - 6, -30 + 6});
}

TEST_CASE("NRRD spaces are converted, plain spacings keep the lattice's axes", "[orientation]") {
  const Folder folder;
  const std::string data = samples<std::uint8_t>(),
                    head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 5 4 3\nencoding: raw\n";
  const auto open = [&](const std::string& fields) {
    return open_volume(write(folder / "a.nrrd", head + fields + "\n" + data))->grid();
  };

  const auto lps = open(
      "space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\n");
  CHECK(lps.spacing == glm::dvec3(2, 3, 4));
  check_near(world(lps, {1, 1, 1}), {3, 5, 7});

  const auto ras = open(
      "space: right-anterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\n");
  check_near(world(ras, {1, 1, 1}), {-3, -5, 7});

  const auto las = open(
      "space: left-anterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\n");
  check_near(world(las, {1, 1, 1}), {3, -5, 7});

  const auto plain = open("spacings: 0.5 1.5 2.5\n");
  CHECK(plain.spacing == glm::dvec3(0.5, 1.5, 2.5));
  CHECK(plain.direction == glm::dmat3(1));

  const auto silent = open("");
  CHECK(silent.spacing == glm::dvec3(1));
}

TEST_CASE("--spacing replaces a file's own spacing", "[orientation]") {
  const Folder folder;
  RawDescription raw;
  raw.spacing = glm::dvec3(1, 1, 2.5);
  const auto source = open_volume(write(folder / "a.nii", Nifti().header() + samples<short>()), raw);
  CHECK(source->grid().spacing == glm::dvec3(1, 1, 2.5));
  CHECK(source->concurrent());
  CHECK((read_all(*source) == samples<short>()));
}

TEST_CASE("a volume's notes tell whose axes the world has", "[orientation]") {
  const Folder folder;
  const auto world_of = [](const std::filesystem::path& path) { return open_volume(path)->notes().world; };
  CHECK(world_of(write(folder / "a.nii", Nifti().header() + samples<short>())) == World::patient);
  const std::string head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 5 4 3\nencoding: raw\n";
  const std::string directions = "space directions: (1,0,0) (0,1,0) (0,0,1)\n\n";
  const auto nrrd = [&](const std::string& fields) {
    return write(folder / "a.nrrd", head + fields + samples<std::uint8_t>());
  };
  CHECK(world_of(nrrd("space: left-posterior-superior\n" + directions)) == World::patient);
  CHECK(world_of(nrrd("space: 3D-right-handed\n" + directions)) == World::lattice);
  CHECK(world_of(nrrd("\n")) == World::lattice);
  CHECK(world_of(write(folder / "a_5x4x3_uint8.raw", samples<std::uint8_t>())) == World::lattice);
}

TEST_CASE("a choice that nothing in the file answers is refused", "[formats]") {
  const Folder folder;
  const auto raw = write(folder / "a_5x4x3_uint8.raw", samples<std::uint8_t>());
  CHECK_NOTHROW(open_volume(raw, {}, {.frame = 0}));
  CHECK_THROWS_WITH(open_volume(raw, {}, {.frame = 1}), Contains("holds one volume"));
  CHECK_THROWS_WITH(open_volume(raw, {}, {.channel = "g"}), Contains("one value a voxel"));
  CHECK_THROWS_WITH(open_volume(raw, {}, {.series = "1.2"}), Contains("no DICOM series"));
}

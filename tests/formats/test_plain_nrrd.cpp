// The reader of NRRD for builds without ITK; where there is ITK, against what that reads.
#include <functional>

#include "formats/files.hpp"
#include "formats/nrrd/plain_nrrd.hpp"
#include "formats/write.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/config.hpp"
#include "support/catch.hpp"
#include "volume/synth.hpp"

using namespace ringsplat;
using namespace files;
using Catch::Matchers::Contains;

namespace {

void check_same(const Grid& grid, const Grid& other) {
  CHECK(grid.dims == other.dims);
  CHECK(grid.spacing == other.spacing);
  CHECK(grid.origin == other.origin);
  CHECK(grid.direction == other.direction);
  CHECK(grid.type == other.type);
}

/// Opens the file both ways; they must agree in all that they say.
std::unique_ptr<VolumeSource> opened(const fs::path& path) {
  auto plain = detail::open_plain_nrrd(path);
  const auto usual = open_volume(path);
  check_same(plain->grid(), usual->grid());
  CHECK(plain->notes().world == usual->notes().world);
  CHECK(plain->notes().unit == usual->notes().unit);
  CHECK(read_all(*plain) == read_all(*usual));
  return plain;
}

std::string header(const std::string& fields, const std::string& type = "int16") {
  return "NRRD0004\n# a comment\ntype: " + type + "\ndimension: 3\nsizes: 5 4 3\nendian: little\n" + fields;
}

}  // namespace

TEST_CASE("the plain reader of NRRD finds voxels where they are", "[nrrd]") {
  const Folder folder;
  const std::string voxels = samples<short>();
  const auto whole = [&](const std::string& fields, const std::string& data) {
    return read_all(*opened(write(folder / "a.nrrd", header(fields) + "\n" + data)));
  };
  CHECK(whole("encoding: raw\n", voxels) == voxels);
  CHECK(whole("encoding: raw\nkey:=value: 3\ncontent: a head\n", voxels) == voxels);
  CHECK(whole("encoding: raw\nbyte skip: 3\n", "abc" + voxels) == voxels);
  CHECK(whole("encoding: raw\nline skip: 2\nbyte skip: 1\n", "one\ntwo\n-" + voxels) == voxels);
  CHECK(whole("encoding: raw\nbyte skip: -1\n", "whatever" + voxels) == voxels);
  CHECK(whole("encoding: gzip\n", gzip(voxels)) == voxels);
  CHECK(whole("encoding: gz\nbyte skip: 3\n", gzip("abc" + voxels)) == voxels);
  CHECK(whole("encoding: ascii\n", text_of_samples()) == voxels);
  CHECK(whole("encoding: text\n", text_of_samples()) == voxels);

  write(folder / "beside.raw", "ab" + voxels);
  const std::string detached = header("encoding: raw\nbyte skip: 2\ndata file: beside.raw\n");
  CHECK(read_all(*opened(write(folder / "a.nhdr", detached))) == voxels);
  std::string dos;
  for (const char c : detached) dos += c == '\n' ? "\r\n" : std::string(1, c);
  CHECK(read_all(*detail::open_plain_nrrd(write(folder / "dos.nhdr", dos))) == voxels);

  std::string big = header("encoding: raw\n");
  big.replace(big.find("little"), 6, "big");
  CHECK(read_all(*opened(write(folder / "big.nrrd", big + "\n" + samples<short>(true)))) == voxels);
}

TEST_CASE("the plain reader of NRRD knows every type and its names", "[nrrd]") {
  const Folder folder;
  const auto type_of = [&](const std::string& name, const std::string& data) {
    return opened(write(folder / "a.nrrd", header("encoding: raw\n", name) + "\n" + data))->grid().type;
  };
  CHECK(type_of("signed char", samples<std::int8_t>()) == ScalarType::int8);
  CHECK(type_of("uchar", samples<std::uint8_t>()) == ScalarType::uint8);
  CHECK(type_of("unsigned char", samples<std::uint8_t>()) == ScalarType::uint8);
  CHECK(type_of("short int", samples<std::int16_t>()) == ScalarType::int16);
  CHECK(type_of("unsigned short int", samples<std::uint16_t>()) == ScalarType::uint16);
  CHECK(type_of("int32_t", samples<std::int32_t>()) == ScalarType::int32);
  CHECK(type_of("unsigned int", samples<std::uint32_t>()) == ScalarType::uint32);
  CHECK(type_of("float", samples<float>()) == ScalarType::float32);
  CHECK(type_of("double", samples<double>()) == ScalarType::float64);
}

TEST_CASE("the plain reader of NRRD places volumes as ITK does", "[nrrd][orientation]") {
  const Folder folder;
  for (const std::string fields :
       {"spacings: 0.5 1.5 2.5\n", "spacings: 0.5 NaN 2.5\n",
        "space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\n",
        "space: RAS\nspace directions: ( 0.9, 0.1, 0.3 ) (0.1,3,0.7) (0,-0.5,4)\nspace origin: (1,-2,3)\n",
        "space: left-anterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0.1,4)\nspace origin: (1,2,3)\n",
        "space: scanner-xyz\nspace directions: (2,0,0) (0,0,3) (0,4,0)\n",
        "space dimension: 3\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\n"}) {
    CAPTURE(fields);
    opened(write(folder / "a.nrrd",
                 header("encoding: raw\nkinds: domain domain domain\n" + fields) + "\n" + samples<short>()));
  }
  const std::string flat =
      "NRRD0001\ntype: short\ndimension: 2\nsizes: 5 12\nendian: little\nencoding: raw\n";
  CHECK(opened(write(folder / "a.nrrd", flat + "\n" + samples<short>()))->grid().dims ==
        glm::ivec3(5, 12, 1));
}

TEST_CASE("the plain reader of NRRD reads what this program writes", "[nrrd]") {
  const Folder folder;
  Grid grid;
  grid.dims = {9, 8, 7};
  grid.spacing = {0.7, 1, 1.3};
  grid.origin = {-3, 0.1, 5};
  grid.type = ScalarType::float32;
  const auto source = synth_source("shell", grid);
  for (const bool compress : {false, true}) {
    write_volume(*source, folder / "shell.nrrd", compress);
    CHECK(read_all(*opened(folder / "shell.nrrd")) == read_all(*source));
  }
  write_volume(*source, folder / "shell.nhdr", false);
  CHECK(read_all(*opened(folder / "shell.nhdr")) == read_all(*source));
}

TEST_CASE("what needs ITK is refused by name of the option that brings it", "[nrrd]") {
  const Folder folder;
  const auto refused = [&](const std::string& text, const std::string& part) {
    const auto path = write(folder / "a.nrrd", text + "\n" + samples<short>());
    CAPTURE(text);
    CHECK_THROWS_WITH(detail::open_plain_nrrd(path),
                      Contains(path.string()) && Contains(part) && Contains("-DRINGSPLAT_WITH_ITK=ON"));
  };
  refused(header("encoding: hex\n"), "encoding hex");
  refused(header("encoding: raw\nkinds: vector domain domain\n"), "kind vector");
  refused(header("encoding: raw\ndata file: LIST\n"), "several data files");
  refused(header("encoding: raw\ndata file: slice%03d.raw 1 3 1\n"), "several data files");
  refused(header("encoding: raw\naxis mins: 0 0 0\n"), "axis mins");
  refused("NRRD0004\ntype: short\ndimension: 4\nsizes: 5 4 3 1\nencoding: raw\nendian: little\n", "4 axes");
}

TEST_CASE("the plain reader of NRRD refuses damaged headers", "[nrrd][bad]") {
  const Folder folder;
  const auto refused = [&](const std::string& text, const std::string& part) {
    const auto path = write(folder / "a.nrrd", text);
    CAPTURE(text);
    CHECK_THROWS_WITH(detail::open_plain_nrrd(path), Contains(folder.path().string()) && Contains(part));
  };
  const std::string raw = "encoding: raw\n";
  refused("", "does not begin");
  refused("NRRX0004\n", "does not begin");
  refused("NRRD0004\n", "dimension");
  refused(header(raw + "sizes: 5 4\n"), "sizes");
  refused(header(raw + "sizes: 5 0 3\n"), "sizes");
  refused(header(raw + "sizes: 5 4 99999999999\n"), "sizes");
  refused(header(raw + "sizes: 2000000000 2000000000 2000000000\n"), "overflow");
  refused(header(raw, "int64"), "type");
  refused(header(raw, "block"), "type");
  refused(header("encoding: bzip2\n"), "encoding");
  refused(header(raw + "endian: middle\n"), "endian");
  refused(header(raw + "spacings: 1 2\n"), "spacings");
  refused(header(raw + "spacings: 1 x 2\n"), "spacings");
  refused(header(raw + "space: LPS\nspace directions: (1,0,0) (0,1,0)\n"), "space directions");
  refused(header(raw + "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,0)\n"), "space directions");
  refused(header(raw + "space: LPS\nspace directions: (1,0,0) (0,nan,0) (0,0,1)\n"), "space directions");
  refused(header(raw + "space origin: (1,2\n"), "space origin");
  refused(header(raw + "byte skip: -2\n"), "byte skip");
  refused(header("encoding: gzip\nbyte skip: -1\n"), "byte skip");
  refused(header(raw + "no colon\n"), "no colon");
  refused(header(raw + "data file: missing.raw\n"), "missing.raw");
  refused(header(raw) + "\n" + samples<short>().substr(1), "");
  refused(header(raw + "line skip: 100\n") + "\n" + samples<short>(), "");
  refused(header("encoding: ascii\n") + "\n1 2 3", "");
}

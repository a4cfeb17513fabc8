#include <fmt/format.h>

#include <algorithm>

#include "formats/bad_files.hpp"
#include "formats/files.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace files;

namespace {

/// `fields`: as many as there are to replace the usual ones of the same names, or to add.
std::string header(const std::vector<std::pair<std::string, std::string>>& fields) {
  std::vector<std::pair<std::string, std::string>> all{
      {"type", "int16"}, {"dimension", "3"}, {"sizes", "5 4 3"}, {"endian", "little"}, {"encoding", "raw"}};
  for (const auto& [name, value] : fields) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const auto& field) { return field.first == name; });
    if (found == all.end())
      all.emplace_back(name, value);
    else
      found->second = value;
  }
  std::string text = "NRRD0004\n# a comment: of two words\n";
  for (const auto& [name, value] : all)
    if (!value.empty()) text += name + ": " + value + "\n";
  return text;
}

using Fields = std::vector<std::pair<std::string, std::string>>;

}  // namespace

TEST_CASE("an NRRD's voxels are found where they are", "[nrrd]") {
  const Folder folder;
  const std::string voxels = samples<short>();
  const auto whole = [&](const Fields& fields, const std::string& data, const std::string& more = {}) {
    return read_all(*open_volume(write(folder / "a.nrrd", header(fields) + more + "\n" + data)));
  };
  CHECK(whole({}, voxels) == voxels);
  CHECK(whole({{"content", "a:=b: c"}}, voxels, "key:=value: 3\nkey: of=b:=c\n") == voxels);
  CHECK(whole({{"byteskip", "3"}}, "abc" + voxels) == voxels);
  CHECK(whole({{"line skip", "2"}, {"byte skip", "1"}}, "one\r\ntwo\n-" + voxels) == voxels);
  CHECK(whole({{"byte skip", "-1"}}, "whatever" + voxels) == voxels);
  CHECK(whole({{"byte skip", "-3"}}, "whatever" + voxels + "xy") == voxels);
  CHECK(whole({{"encoding", "GZip"}}, gzip(voxels)) == voxels);
  CHECK(whole({{"encoding", "gz"}, {"byte skip", "3"}}, gzip("abc" + voxels)) == voxels);
  CHECK(whole({{"encoding", "txt"}, {"endian", ""}}, text_of_samples()) == voxels);
  std::string commas = text_of_samples();
  std::replace(commas.begin(), commas.end(), '\n', ',');
  CHECK(whole({{"encoding", "ascii"}}, commas) == voxels);
  CHECK(whole({{"endian", "Big"}}, samples<short>(true)) == voxels);
  CHECK(whole({{"dimension", "4"}, {"sizes", "5 4 3 1"}, {"encoding", "text"}}, text_of_samples()) == voxels);
}

TEST_CASE("an NRRD's voxels may be in files of their own", "[nrrd]") {
  const Folder folder;
  const std::string voxels = samples<short>();
  const auto whole = [&](const std::string& text) {
    return read_all(*open_volume(write(folder / "a.nhdr", text)));
  };
  write(folder / "50%.raw", "ab" + voxels);
  const auto detached = header({{"byte skip", "2"}, {"data file", "50%.raw"}});
  CHECK(whole(detached) == voxels);
  std::string dos, mac = detached;
  for (const char c : detached) dos += c == '\n' ? "\r\n" : std::string(1, c);
  std::replace(mac.begin(), mac.end(), '\n', '\r');
  CHECK(whole(dos) == voxels);
  CHECK(whole(mac) == voxels);

  for (int row = 0; row < ny * nz; ++row)
    write(folder / fmt::format("r{:02}.raw", row), "-" + voxels.substr(std::size_t(row) * 10, 10));
  for (int z = 0; z < nz; ++z) {
    write(folder / fmt::format("s{}.raw", z), "-" + voxels.substr(std::size_t(z) * 40, 40));
    write(folder / fmt::format("t{}.raw", z), slice_of_samples(z, true) + "xyz");
  }
  const auto list = [](const std::string& files, const std::string& skip = "1") {
    return header({{"byte skip", skip}, {"data file", files}});
  };
  CHECK(whole(list("s%d.raw 0 2 1")) == voxels);
  CHECK(whole(list("s%01d.raw 0 2 1 2")) == voxels);
  CHECK(whole(list("r%02d.raw 0 11 1 1")) == voxels);
  CHECK(whole(list("LIST\ns0.raw\ns1.raw\ns2.raw")) == voxels);  // no line break at the end
  CHECK(whole(list("LIST 2\ns0.raw\ns1.raw\ns2.raw\n\nwhatever")) == voxels);
  CHECK(whole(list("LIST 3\ns0.raw\ns1.raw\ns2.raw\n")) == voxels);
  CHECK(whole(list("s%d.raw 2 0 -1")) == voxels.substr(80) + voxels.substr(40, 40) + voxels.substr(0, 40));
  CHECK(whole(header({{"byte skip", "-4"}, {"endian", "big"}, {"data file", "t%d.raw 0 2 1"}})) == voxels);
}

TEST_CASE("an NRRD may name its type in many ways", "[nrrd]") {
  const Folder folder;
  const auto type_of = [&](const std::string& name, const std::string& data) {
    return open_volume(write(folder / "a.nrrd", header({{"type", name}}) + "\n" + data))->grid().type;
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

TEST_CASE("an NRRD without a space lies where its axes begin", "[nrrd][orientation]") {
  const Folder folder;
  const auto grid_of = [&](const Fields& fields) {
    return open_volume(write(folder / "a.nrrd", header(fields) + "\n" + samples<short>()))->grid();
  };
  CHECK(grid_of({{"spacings", "0.5 NaN 2.5"}}).spacing == glm::dvec3(0.5, 1, 2.5));
  // The first cell's centre is half a voxel behind its beginning, a node is there.
  CHECK(grid_of({{"axis mins", "1 2 3"}, {"spacings", "1 2 4"}}).origin == glm::dvec3(1.5, 3, 5));
  CHECK(grid_of({{"axis mins", "1 2 3"}, {"axis maxs", "6 10 4.5"}}).origin == glm::dvec3(1.5, 3, 3.25));
  CHECK(grid_of({{"axis mins", "1 2 3"}, {"spacings", "1 2 4"}, {"centerings", "node cell ???"}}).origin ==
        glm::dvec3(1, 3, 5));
  CHECK(grid_of({{"axis mins", "1 2 3"}}).origin == glm::dvec3(0));
  const Grid flat = grid_of({{"dimension", "2"},
                             {"sizes", "5 12"},
                             {"space", "LPS"},
                             {"space directions", "(0,2,0) (0,0,3)"},
                             {"space origin", "(7,8,9)"}});
  CHECK(flat.dims == glm::ivec3(5, 12, 1));
  CHECK(flat.spacing == glm::dvec3(2, 3, 1));
  CHECK(flat.direction[2] == glm::dvec3(1, 0, 0));
}

TEST_CASE("damaged headers of NRRD are refused", "[nrrd][bad]") {
  const auto with = [](const Fields& fields) { return header(fields) + "\n" + samples<short>(); };
  const auto directions = [&](const std::string& text) {
    return with({{"space", "LPS"}, {"space directions", text}});
  };
  check_all({
      file("another magic", "does not begin", "a.nrrd", "NRRX0004\n"),
      file("no fields", "'dimension' is missing", "a.nrrd", "NRRD0004\n"),
      file("no type", "'type' is missing", "a.nrrd", with({{"type", ""}})),
      file("no encoding", "'encoding' is missing", "a.nrrd", with({{"encoding", ""}})),
      file("17 axes", "dimension is '17'", "a.nrrd", with({{"dimension", "17"}})),
      file("too few sizes", "2 sizes, but its dimension is 3", "a.nrrd", with({{"sizes", "5 4"}})),
      file("a size in words", "sizes is 'five", "a.nrrd", with({{"sizes", "five 4 3"}})),
      file("blocks", "'block' cannot be rendered", "a.nrrd", with({{"type", "block"}})),
      file("middle endian", "endian is 'middle'", "a.nrrd", with({{"endian", "middle"}})),
      file("too few spacings", "2 spacings", "a.nrrd", with({{"spacings", "1 2"}})),
      file("a spacing in words", "spacings is '1 x 2'", "a.nrrd", with({{"spacings", "1 x 2"}})),
      file("too few directions", "space directions is", "a.nrrd", directions("(1,0,0) (0,1,0)")),
      file("no direction", "space directions is", "a.nrrd", directions("(1,0,0) (0,1,0) (0,0,0)")),
      file("half a direction", "space directions is", "a.nrrd", directions("(1,0,0) (0,nan,0) (0,0,1)")),
      file("flat directions", "space directions is", "a.nrrd", directions("(1,0) (0,1) (1,1)")),
      file("directions without a space", "has no space", "a.nrrd",
           with({{"space directions", "(1,0,0) (0,1,0) (0,0,1)"}})),
      file("directions and spacings", "space direction and spacing", "a.nrrd",
           with({{"space", "LPS"}, {"space directions", "(1,0,0) (0,1,0) (0,0,1)"}, {"spacings", "1 1 1"}})),
      file("an open origin", "space origin is '(1,2'", "a.nrrd",
           with({{"space", "LPS"}, {"space origin", "(1,2"}})),
      file("an unknown space", "space is 'the moon'", "a.nrrd", with({{"space", "the moon"}})),
      file("negative lines", "line skip is '-1'", "a.nrrd", with({{"line skip", "-1"}})),
      file("too many lines", "promises 120 bytes", "a.nrrd", with({{"line skip", "1000"}})),
      file("backwards in gzip", "byte skip is '-1'", "a.nrrd",
           with({{"encoding", "gzip"}, {"byte skip", "-1"}})),
      file("no header line", "'no colon' is no line", "a.nrrd", "NRRD0004\nno colon\n"),
      file("an unknown field", "'colour: red' is no line", "a.nrrd", with({{"colour", "red"}})),
      file("a field twice", "'sizes' is given twice", "a.nrrd",
           header({}) + "sizes: 5 4 3\n\n" + samples<short>()),
      file("no hexadecimal digits", "no hexadecimal digit", "a.nrrd",
           header({{"encoding", "hex"}}) + "\n" + std::string(240, 'g')),
      file("too many files", "data file is", "a.nrrd", with({{"data file", "s%d.raw 0 2000000000 1"}})),
      file("files in no order", "data file is", "a.nrrd", with({{"data file", "s%d.raw 2 0 1"}})),
      file("files by no step", "data file is", "a.nrrd", with({{"data file", "s%d.raw 0 2 0"}})),
      file("files of four axes", "data file is", "a.nrrd", with({{"data file", "s%d.raw 0 2 1 4"}})),
  });
}

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "formats/bad_files.hpp"
#include "formats/captured_log.hpp"
#include "formats/vti.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"

using namespace files;
using Catch::Matchers::Contains;

namespace {

const Vti::Array shorts{"ct", "Int16", samples<short>()};

Vti with_shorts(Vti vti = {}) {
  vti.arrays = {shorts};
  return vti;
}

/// Every kind of file that VTK writes.
void for_each_kind(const std::function<void(const Vti&)>& use) {
  for (const auto& [format, encoding] : {std::pair("ascii", "raw"), std::pair("binary", "raw"),
                                         std::pair("appended", "raw"), std::pair("appended", "base64")})
    for (const char* compressor : {"", "ZLib", "LZ4", "LZMA"})
      for (const bool wide : {false, true})
        for (const bool big : {false, true}) {
          if (format == std::string("ascii") && (*compressor != '\0' || wide)) continue;
          Vti vti;
          vti.format = format, vti.encoding = encoding, vti.compressor = compressor;
          vti.wide_numbers = wide, vti.big_endian = vti.keys_behind = big;
          vti.arrays = {shorts};
          vti.arrays[0].bytes = vti.format == "ascii" ? text_of_samples() : samples<short>(big);
          use(vti);
        }
}

}  // namespace

TEST_CASE("every kind of VTK image file gives the same voxels, whole, by slice and backwards", "[vti]") {
  int kinds = 0;
  for_each_kind([&](const Vti& vti) {
    CAPTURE(vti.format, vti.encoding, vti.compressor, vti.wide_numbers, vti.big_endian);
    for (const std::size_t block : {32U, 40U, 7U, 120U, 500U}) {
      if (vti.compressor.empty() && block != 32) continue;
      CAPTURE(block);
      auto blocks = vti;
      blocks.block = block;
      const Folder folder;
      const auto source = open_volume(write(folder / "a.vti", blocks.file()));
      CHECK(source->grid().spacing == glm::dvec3(1, 2, 3));
      CHECK(source->concurrent() == (vti.format == "appended" && vti.encoding == "raw"));
      CHECK(source->notes().quantity == "ct");
      CHECK(is_sample(*source));
      ++kinds;
    }
  });
  CHECK(kinds == 2 + 3 * 4 * (1 + 3 * 5));
}

TEST_CASE("a VTK image file is refused wherever its data is cut", "[vti][bad]") {
  for_each_kind([](const Vti& vti) {
    if (vti.wide_numbers || vti.big_endian) return;
    CAPTURE(vti.format, vti.encoding, vti.compressor);
    const Folder folder;
    const auto whole = vti.file();
    // What follows the appended data is not read.
    const auto end = vti.format == "appended" ? whole.rfind("\n  </AppendedData>") : whole.size() - 2;
    for (std::size_t length = 0; length < end; length += length + 60 < end ? 97 : 1) {
      CAPTURE(length, end);
      CHECK_THROWS_AS(voxels_of(write(folder / "a.vti", whole.substr(0, length))), InputError);
    }
  });
}

TEST_CASE("all scalar types of a VTK image", "[vti]") {
  const Folder folder;
  const std::pair<ScalarType, const char*> names[] = {
      {ScalarType::int8, "Int8"},       {ScalarType::uint8, "UInt8"},    {ScalarType::int16, "Int16"},
      {ScalarType::uint16, "UInt16"},   {ScalarType::int32, "Int32"},    {ScalarType::uint32, "UInt32"},
      {ScalarType::float32, "Float32"}, {ScalarType::float64, "Float64"}};
  for (const auto& [type, name] : names)
    for (const bool big : {false, true}) {
      CAPTURE(name, big);
      Vti vti;
      vti.big_endian = big;
      vti.arrays = {{"a", name, samples_of(type, big)}};
      const auto source = open_volume(write(folder / "a.vti", vti.file()));
      CHECK(source->grid().type == type);
      CHECK((read_all(*source) == samples_of(type)));
    }
}

TEST_CASE("a VTK image lies where its extent, origin, spacing and direction say", "[vti][orientation]") {
  const Folder folder;
  auto vti = with_shorts();
  vti.extent = vti.piece = "10 14 -3 0 2 4";
  vti.version = "2.2";
  vti.image = "Origin=\"1 2 3\" Spacing=\"0.5 2 4\" Direction=\"0 -1 0 1 0 0 0 0 1\"";
  const auto grid = open_volume(write(folder / "a.vti", vti.file()))->grid();
  CHECK(grid.dims == glm::ivec3(nx, ny, nz));
  CHECK(grid.spacing == glm::dvec3(0.5, 2, 4));
  // Rows of the matrix follow each other: x leads to world y, y to -x.
  CHECK(grid.direction[0] == glm::dvec3(0, 1, 0));
  CHECK(grid.direction[1] == glm::dvec3(-1, 0, 0));
  CHECK(grid.origin == glm::dvec3(1 + 3 * 2, 2 + 10 * 0.5, 3 + 2 * 4));

  auto cells = with_shorts();
  cells.arrays[0].of_cells = true;
  cells.extent = cells.piece = "0 5 0 4 0 3";
  const auto source = open_volume(write(folder / "b.vti", cells.file()));
  CHECK(source->grid().dims == glm::ivec3(nx, ny, nz));
  CHECK(source->grid().origin == glm::dvec3(0.5, 1, 1.5));
  CHECK((read_all(*source) == samples<short>()));
  cells.extent = cells.piece = "0 20 0 3 2 2";
  CHECK(open_volume(write(folder / "c.vti", cells.file()))->grid().dims == glm::ivec3(20, 3, 1));
}

TEST_CASE("of a VTK image's arrays the active one is taken, or the one named", "[vti]") {
  const Folder folder;
  Vti vti;
  const std::string other(60, 'x');
  vti.arrays = {{"other", "UInt8", other}, shorts, {"masses", "UInt8", std::string(24, 'm'), 1, true}};
  const auto path = write(folder / "a.vti", vti.file());
  CHECK_THROWS_WITH(open_volume(path), Contains("holds 3 arrays") && Contains("other, ct, masses"));
  CHECK((voxels_of(path, {.channel = "ct"}) == samples<short>()));
  CHECK(voxels_of(path, {.channel = "masses"}) == std::string(24, 'm'));
  CHECK_THROWS_WITH(open_volume(path, {}, {.channel = "none"}), Contains("no such array"));
  vti.point_scalars = "ct";
  vti.cell_scalars = "masses";
  CHECK((voxels_of(write(folder / "b.vti", vti.file())) == samples<short>()));
  CHECK(voxels_of(folder / "b.vti", {.channel = "other"}) == other);
  vti.point_scalars.clear();
  CHECK(voxels_of(write(folder / "c.vti", vti.file())) == std::string(24, 'm'));

  // ParaView's marks of hidden points are no volume.
  vti.arrays = {{"vtkGhostType", "UInt8", other}, shorts};
  CHECK((voxels_of(write(folder / "d.vti", vti.file())) == samples<short>()));
}

TEST_CASE("a VTK image's vectors need a component, its colours become luminance", "[vti]") {
  const Folder folder;
  Vti vti;
  for (const char* compressor : {"", "LZ4"}) {
    vti.compressor = compressor;
    vti.arrays = {{"v", "Int16", interleaved(2, 1), 2}};
    const auto path = write(folder / "a.vti", vti.file());
    CHECK_THROWS_WITH(open_volume(path), Contains("array 'v': a voxel is a vector of 2"));
    CHECK((voxels_of(path, {.channel = "1"}) == samples<short>()));
    CHECK((voxels_of(path, {.channel = "v:1"}) == samples<short>()));
    CHECK_THROWS_WITH(open_volume(path, {}, {.channel = "v:2"}), Contains("no such channel"));
    vti.arrays.push_back({"other", "UInt8", std::string(60, 'x')});
    CHECK((voxels_of(write(folder / "a.vti", vti.file()), {.channel = "v:1"}) == samples<short>()));
  }
  vti.format = "ascii";
  vti.compressor.clear();
  vti.extent = vti.piece = "0 1 0 0 0 0";
  vti.arrays = {{"rgb", "UInt8", "255 0 0\n7 7 7", 3}};
  const CapturedLog log;
  CHECK(voxels_of(write(folder / "rgb.vti", vti.file())) == "\x36\7");
  CHECK(says(log.text(), "array 'rgb': voxels are colours"));
  CHECK(voxels_of(folder / "rgb.vti", {.channel = "g"}) == std::string("\0\7", 2));
}

TEST_CASE("VTK image files that lie about themselves are refused", "[vti][bad]") {
  const auto raw = with_shorts().file();
  const auto bad = [](const char* what, const char* message, const std::string& bytes) {
    return file(what, message, "a.vti", bytes);
  };
  const auto changed = [&](const char* what, const char* message, const char* from, const char* to) {
    return bad(what, message, replaced(raw, from, to));
  };
  const auto packed_with = [](const char* compressor, std::size_t at, std::uint32_t value) {
    Vti vti = with_shorts();
    vti.compressor = compressor;
    auto bytes = vti.file();
    const auto begin = bytes.find("   _") + 4;
    return bytes.replace(begin + 4 * at, 4, bytes_of(value));
  };
  const auto garbled = [](const char* compressor) {
    Vti vti = with_shorts();
    vti.compressor = compressor;
    auto bytes = vti.file();
    const auto begin = bytes.find("   _") + 4 + 4 * (3 + 4);  // behind the sizes of four blocks
    return bytes.replace(begin, 12, std::string(12, '\x7f'));
  };
  auto in_base64 = with_shorts();
  in_base64.format = "binary";
  const auto text = in_base64.file();
  const auto letters = text.find(base64(in_base64.number(120) + samples<short>()));
  REQUIRE(letters != std::string::npos);
  auto strange = text, padded = text;
  strange[letters + 50] = '!';
  padded[letters + 9] = '=', padded[letters + 10] = 'A';
  std::string deep = "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\">";
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  check_all({
      bad("empty", "is no XML", ""),
      bad("prose", "line 1 is no XML", "hello"),
      bad("other XML", "its XML is of 'svg'", "<svg/>"),
      bad("other kind", "it holds 'PolyData'", "<VTKFile type=\"PolyData\"/>"),
      bad("no image", "holds no ImageData", "<VTKFile type=\"ImageData\"/>"),
      bad("deep", "is no XML", deep),
      bad("a document type", "declares a document type",
          "<!DOCTYPE x [<!ENTITY a \"b\">]>\n<VTKFile type=\"ImageData\">&a;</VTKFile>"),
      bad("unfinished", "is no XML", "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\">"),
      bad("no piece", "no Piece",
          "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\"/></VTKFile>"),
      bad("no extent", "WholeExtent is missing", "<VTKFile type=\"ImageData\"><ImageData/></VTKFile>"),
      changed("byte order", "byte_order is 'Middle'", "LittleEndian", "Middle"),
      changed("compressor", "compressor is 'vtkNoDataCompressor'", "header_type=\"UInt32\"",
              "compressor=\"vtkNoDataCompressor\""),
      changed("length of lengths", "header_type is 'UInt16'", "UInt32", "UInt16"),
      changed("five numbers", "WholeExtent has 5 numbers", "0 4 0 3 0 2", "0 4 0 3 0"),
      changed("backwards", "its extent is 4 to 0", "Piece Extent=\"0 4", "Piece Extent=\"4 0"),
      changed("extent beyond int", "has '3000000000'", "0 4 0 3 0 2", "0 3000000000 0 3 0 2"),
      changed("overflow", "overflow 64 bits", "Piece Extent=\"0 4 0 3 0 2",
              "Piece Extent=\"0 2000000000 0 2000000000 0 2000000000"),
      changed("a piece without arrays", "has no array 'ct' of Int16 points with 1 numbers", "</Piece>",
              "</Piece><Piece Extent=\"0 4 0 3 0 0\"/>"),
      bad("no piece with points", "they hold 0 of 60 voxels",
          replaced(replaced(raw, "Piece Extent=\"0 4", "Piece Extent=\"4 0"), "</Piece>",
                   "</Piece><Piece Extent=\"0 4 0 3 1 0\"/>")),
      bad("an array without a piece", "no Piece",
          "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\"><PointData><DataArray "
          "format=\"ascii\">1</DataArray></PointData></ImageData></VTKFile>"),
      changed("spacing", "spacing 0 2 3", "Spacing=\"1", "Spacing=\"0"),
      changed("singular direction", "direction matrix is singular", "Spacing",
              "Direction=\"1 0 0 1 0 0 0 0 1\" Spacing"),
      bad("no arrays", "no array of points or cells", Vti().file()),
      changed("type", "type 'Int64' cannot", "Int16", "Int64"),
      changed("components", "no number of components", "NumberOfComponents=\"1", "NumberOfComponents=\"0"),
      changed("too many components", "rows of 5 voxels", "NumberOfComponents=\"1",
              "NumberOfComponents=\"2147483647"),
      changed("format", "format is 'strange'", "appended", "strange"),
      changed("no offset", "has no offset", "offset=", "place="),
      changed("far offset", "behind the end", "offset=\"0", "offset=\"99999999999999"),
      changed("encoding", "encoding is 'hex'", "encoding=\"raw", "encoding=\"hex"),
      changed("no underscore", "underscore", "   _", "    "),
      bad("no appended data", "but no data is", raw.substr(0, raw.find("<AppendedData")) + "</VTKFile>"),
      bad("length", "has 121 bytes, its extent needs 120",
          replaced(raw, "   _" + bytes_of(120), "   _" + bytes_of(121))),
      bad("numbers missing", "promises 119 bytes",
          replaced(replaced(raw, "format=\"appended\"", "format=\"ascii\""), "/>\n</PointData>",
                   ">1 2 3</DataArray>\n</PointData>")),
      bad("strange letter", "is no base64", strange),
      bad("letter behind padding", "is no base64", padded),
      bad("no blocks", "has 0 blocks", packed_with("ZLib", 0, 0)),
      bad("many blocks", "blocks of 32 bytes", packed_with("ZLib", 0, 0xFFFFFFFF)),
      bad("one block more", "has 5 blocks of 32 bytes, its extent needs 120", packed_with("ZLib", 0, 5)),
      bad("no bytes", "blocks of 0 bytes", packed_with("ZLib", 1, 0)),
      bad("huge blocks", "its extent needs 120", packed_with("ZLib", 1, 0xFFFFFFFF)),
      bad("last block", "blocks of 32 bytes", packed_with("ZLib", 2, 33)),
      bad("compressed size", "compressed bytes, the file has fewer", packed_with("ZLib", 3, 0xFFFFFFF0)),
      bad("short zlib block", "damaged block, 1 of 4", packed_with("ZLib", 3, 9)),
      bad("short LZ4 block", "damaged block, 1 of 4", packed_with("LZ4", 3, 9)),
      bad("short LZMA block", "damaged block, 1 of 4", packed_with("LZMA", 3, 9)),
      bad("garbled zlib", "damaged block", garbled("ZLib")),
      bad("garbled LZMA", "damaged block", garbled("LZMA")),
  });
}

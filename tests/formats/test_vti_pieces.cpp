#include <fmt/format.h>

#include <algorithm>

#include "formats/bad_files.hpp"
#include "formats/vti.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"

using namespace files;
using Catch::Matchers::Contains;

namespace {

/// Points of the sample volume, first and last along each axis.
struct Box {
  int x0, x1, y0, y1, z0, z1;
  std::string text() const { return fmt::format("{} {} {} {} {} {}", x0, x1, y0, y1, z0, z1); }
  std::string samples() const {
    std::string bytes;
    for (int z = z0; z <= z1; ++z)
      for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) bytes += bytes_of(sample<short>(x, y, z));
    return bytes;
  }
};
const Box left{0, 2, 0, 3, 0, 2}, lower{2, 4, 0, 3, 0, 1}, upper{2, 4, 0, 3, 1, 2};

Vti piece(const Box& box, Vti vti = {}) {
  vti.extent = vti.piece = box.text();
  vti.arrays = {{"ct", "Int16", box.samples()}};
  return vti;
}

/// Of pieces that are files of their own, a.vti and so on.
std::string parallel(const std::vector<std::string>& extents, const std::string& ghosts = "0") {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PImageData\">\n<PImageData WholeExtent=\"0 4 0 3 0 2\" "
      "GhostLevel=\"" +
      ghosts + "\" Origin=\"1 2 3\" Spacing=\"1 2 3\">\n<PPointData Scalars=\"ct\">" +
      "<PDataArray type=\"Int16\" Name=\"ct\"/></PPointData>\n";
  char name = 'a';
  for (const auto& extent : extents)
    text += fmt::format("<Piece Extent=\"{}\" Source=\"{}.vti\"/>\n", extent, name++);
  return text + "</PImageData>\n</VTKFile>\n";
}

/// That of `pieces`, which it writes.
fs::path write_parallel(const Folder& folder, const std::vector<Vti>& pieces,
                        const std::string& ghosts = "0") {
  std::vector<std::string> extents;
  char name = 'a';
  for (const auto& one : pieces) {
    write(folder / (std::string(1, name++) + ".vti"), one.file());
    extents.push_back(one.piece);
  }
  return write(folder / "all.pvti", parallel(extents, ghosts));
}

std::vector<Vti> all_pieces(const Vti& how = {}) {
  return {piece(left, how), piece(lower, how), piece(upper, how)};
}

}  // namespace

TEST_CASE("pieces of a VTK image that are files of their own make one volume", "[vti]") {
  for (const char* compressor : {"", "ZLib"}) {
    CAPTURE(compressor);
    Vti how;
    how.compressor = compressor;
    const Folder folder;
    const auto source = open_volume(write_parallel(folder, all_pieces(how)));
    CHECK(source->grid().origin == glm::dvec3(1, 2, 3));
    CHECK(source->concurrent());
    CHECK(source->notes().quantity == "ct");
    CHECK(is_sample(*source));
    const auto facts = source->facts();
    CHECK(std::ranges::count_if(facts, [](const Fact& fact) { return says(fact.value, ".vti"); }) == 3);
    write(folder / "b.vti", "another file");
    CHECK_THROWS_WITH(read_all(*source), Contains("b.vti") && Contains("changed"));
  }
}

TEST_CASE("pieces that also hold their neighbours' points make one volume", "[vti]") {
  const Folder folder;
  const auto path = write_parallel(
      folder, {piece({0, 3, 0, 3, 0, 2}), piece({1, 4, 0, 3, 0, 2}), Vti(piece({0, 0, 0, 0, 1, 0}))}, "1");
  CHECK((read_all(*open_volume(path)) == samples<short>()));
}

TEST_CASE("a VTK image file of several pieces is one volume", "[vti]") {
  const Folder folder;
  std::string text =
      "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 4 0 3 0 2\" Spacing=\"1 2 3\">\n";
  for (const Box& box : {lower, left, upper}) {
    text += "<Piece Extent=\"" + box.text() + "\"><PointData><DataArray type=\"Int16\" Name=\"ct\">";
    for (int z = box.z0; z <= box.z1; ++z)
      for (int y = box.y0; y <= box.y1; ++y)
        for (int x = box.x0; x <= box.x1; ++x) text += fmt::format(" {}", sample<short>(x, y, z));
    text += "</DataArray></PointData></Piece>\n";
  }
  CHECK(
      (read_all(*open_volume(write(folder / "a.vti", text + "</ImageData></VTKFile>"))) == samples<short>()));
}

TEST_CASE("cells and vectors of a VTK image in pieces", "[vti]") {
  const Folder folder;
  Vti a, b;
  a.extent = a.piece = "0 1 0 2 0 1";
  a.arrays = {{"v", "UInt8", "abcd", 2, true}};
  b.extent = b.piece = "1 4 0 2 0 1";
  b.arrays = {{"v", "UInt8", "efghijklmnop", 2, true}};
  write(folder / "a.vti", a.file());
  write(folder / "b.vti", b.file());
  const auto path =
      write(folder / "all.pvti", replaced(parallel({a.piece, b.piece}), "0 4 0 3 0 2", "0 4 0 2 0 1"));
  const auto source = open_volume(path, {}, {.channel = "1"});
  CHECK(source->grid().dims == glm::ivec3(4, 2, 1));
  CHECK(read_all(*source) == "bfhjdlnp");
}

TEST_CASE("pieces of a VTK image that do not make one are refused", "[vti][bad]") {
  const auto of = [](std::vector<Vti> pieces) {
    return [=](const Folder& folder) { return write_parallel(folder, pieces); };
  };
  auto pieces = all_pieces();
  const auto changed = [&](auto&& change) {
    auto some = pieces;
    change(some[1]);
    return of(some);
  };
  const auto extents = [](const std::vector<std::string>& list) {
    return [=](const Folder& folder) {
      write_parallel(folder, all_pieces());
      return write(folder / "all.pvti", parallel(list));
    };
  };
  check_all({
      {"a gap", "leave a gap: they hold 48 of 60 voxels", of({pieces[0], pieces[2]})},
      {"twice", "overlap", of({pieces[0], pieces[1], pieces[1], pieces[2]})},
      {"too large", "overlap", of({piece({0, 3, 0, 3, 0, 2}), pieces[1], pieces[2]})},
      {"outside", "a piece's extent is 2 to 5 along axis 0, the whole's 0 to 4",
       of({pieces[0], pieces[1], piece({2, 5, 0, 3, 1, 2})})},
      {"another type", "has no array 'ct' of Int16 points",
       changed([](Vti& vti) { vti.arrays[0].type = "UInt16"; })},
      {"another name", "has no array 'ct' of Int16 points",
       changed([](Vti& vti) { vti.arrays[0].name = "mr"; })},
      {"cut short", "has 47 bytes, its extent needs 48",
       changed([](Vti& vti) { vti.arrays[0].bytes.pop_back(); })},
      {"missing", "d.vti: No such file", extents({left.text(), lower.text(), upper.text(), "0 4 0 3 0 2"})},
      {"no pieces", "no Piece", extents({})},
      {"itself", "it holds 'PImageData'",
       [](const Folder& folder) { return write(folder / "a.vti", parallel({left.text()})); }},
      file("no source", "has no Source, line 5", "a.pvti",
           replaced(parallel({"0 4 0 3 0 2"}), "Source", "File")),
  });
}

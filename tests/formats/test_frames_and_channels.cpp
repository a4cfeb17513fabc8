// Volumes of several time points or several numbers a voxel, in NRRD, MetaImage and legacy VTK files. NIfTI,
// NumPy and VTK's XML files have tests of their own.
#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "formats/bad_files.hpp"
#include "formats/captured_log.hpp"
#include "formats/files.hpp"
#include "support/catch.hpp"

using namespace files;
using Catch::Matchers::Contains;

namespace {

const std::string little = samples<short>(), other(120, 'x');

std::string nrrd(const std::string& fields, const std::string& data, bool packed) {
  return std::string("NRRD0005\ntype: short\nendian: little\nencoding: ") + (packed ? "gzip\n" : "raw\n") +
         fields + "\n" + (packed ? gzip(data) : data);
}

bool same_place(const Grid& a, const Grid& b) {
  return a.dims == b.dims && a.spacing == b.spacing && a.origin == b.origin && a.direction == b.direction;
}

}  // namespace

TEST_CASE("an NRRD's axes of time and lists are frames, wherever they stand", "[nrrd][frames]") {
  const std::string behind = other + little + other, interlaced = interleaved(3, 1);
  const struct {
    const char* fields;
    const std::string& data;
  } kinds[] = {
      {"dimension: 4\nsizes: 5 4 3 3\nkinds: domain domain domain time\n", behind},
      {"dimension: 4\nsizes: 5 4 3 3\nkinds: domain domain domain list\n", behind},
      {"dimension: 4\nsizes: 5 4 3 3\nkinds: space space space domain\n", behind},
      {"dimension: 4\nsizes: 5 4 3 3\n", behind},
      {"dimension: 4\nsizes: 5 4 3 3\nspace: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) "
       "(0,0,1) none\n",
       behind},
      {"dimension: 4\nsizes: 5 4 3 3\nspace dimension: 4\nspace directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) "
       "(0,0,0,1)\n",
       behind},
      {"dimension: 5\nsizes: 5 4 3 1 3\n", behind},
      {"dimension: 4\nsizes: 3 5 4 3\nkinds: list domain domain domain\n", interlaced},
      {"dimension: 4\nsizes: 3 5 4 3\nkinds: time space space space\n", interlaced},
  };
  const Folder folder;
  for (const auto& kind : kinds)
    for (const bool packed : {false, true}) {
      CAPTURE(kind.fields, packed);
      const auto path = write(folder / "a.nrrd", nrrd(kind.fields, kind.data, packed));
      CHECK(open_volume(path)->notes().frames == 3);
      CHECK(open_volume(path)->notes().channels == 1);
      CHECK(open_volume(path)->concurrent() != packed);
      CHECK((voxels_of(path, {.frame = 1}) == little));
      CHECK((voxels_of(path) != little));
      const auto second = open_volume(path, {}, {.frame = 1});
      for (const int z : {2, 0, 1}) CHECK((read_slice(*second, z) == slice_of_samples(z)));
      CHECK_THROWS_WITH(open_volume(path, {}, {.frame = 3}), Contains("holds 3 volumes"));
    }
}

TEST_CASE("an NRRD's axis of vectors or colours is of channels", "[nrrd][channels]") {
  const Folder folder;
  for (const bool packed : {false, true}) {
    const auto vectors =
        write(folder / "v.nrrd", nrrd("dimension: 4\nsizes: 2 5 4 3\nkinds: vector domain domain domain\n",
                                      interleaved(2, 1), packed));
    CHECK((voxels_of(vectors, {.channel = "1"}) == little));
    CHECK_THROWS_WITH(open_volume(vectors), Contains("vector of 2 numbers"));
    const auto planes = write(
        folder / "p.nrrd",
        nrrd("dimension: 4\nsizes: 5 4 3 2\nkinds: domain domain domain vector\n", other + little, packed));
    CHECK((voxels_of(planes, {.channel = "1"}) == little));
    CHECK_THROWS_WITH(open_volume(planes), Contains("vector of 2 numbers"));
    const auto both =
        write(folder / "b.nrrd",
              nrrd("dimension: 5\nsizes: 2 5 4 3 2\nkinds: covariant-vector space space space time\n",
                   std::string(240, 'x') + interleaved(2, 0), packed));
    CHECK((voxels_of(both, {.frame = 1, .channel = "0"}) == little));
    CHECK(open_volume(both, {}, {.channel = "0"})->notes().frames == 2);
  }
  const std::string colours = "NRRD0005\ntype: uint8\nencoding: raw\ndimension: 3\nsizes: 3 2 1\n";
  const auto rgb = write(folder / "rgb.nrrd",
                         colours + "kinds: RGB-color domain domain\n\n" + std::string("\xff\0\0\7\7\7", 6));
  const CapturedLog log;
  CHECK(open_volume(rgb)->grid().dims == glm::ivec3(2, 1, 1));
  CHECK(voxels_of(rgb) == "\x36\7");
  CHECK(says(log.text(), "rgb.nrrd: voxels are colours"));
  CHECK(voxels_of(rgb, {.channel = "b"}) == std::string("\0\7", 2));
}

TEST_CASE("one of an NRRD's frames or channels lies where a volume by itself would", "[nrrd][orientation]") {
  const Folder folder;
  const struct {
    const char *space, *directions, *spacings;
  } places[] = {
      {"space: left-posterior-superior\nspace origin: (1,2,3)\n", "(2,0,0) (0,0,3) (0,-4,0)", ""},
      {"space: right-anterior-superior\nspace origin: (1,2,3)\n", "(2,0,0.5) (0,3,0) (0,0,4)", ""},
      {"space: left-anterior-superior\nspace origin: (1,2,3)\n", "(2,0,0) (0,3,0) (1,0,4)", ""},
      {"space: 3D-left-handed\n", "(2,0,0) (0,3,0) (0,0,4)", ""},
      {"", "", "0.5 1.5 2.5"},
      {"", "", ""},
  };
  for (const auto& place : places) {
    CAPTURE(place.space, place.spacings);
    const std::string directions = place.directions, spacings = place.spacings;
    const auto fields = [&](const std::string& before, const std::string& behind) {
      std::string text = place.space;
      if (!directions.empty())
        text += std::string("space directions: ") + (before.empty() ? "" : "none ") + directions +
                (behind.empty() ? "" : " none") + "\n";
      if (!spacings.empty())
        text += std::string("spacings: ") + (before.empty() ? "" : "nan ") + spacings +
                (behind.empty() ? "" : " 9") + "\n";
      return text + "kinds: " + before + "domain domain domain" + behind + "\n";
    };
    const auto alone = open_volume(
        write(folder / "1.nrrd", nrrd("dimension: 3\nsizes: 5 4 3\n" + fields("", ""), little, false)));
    const auto frame =
        open_volume(write(folder / "2.nrrd", nrrd("dimension: 4\nsizes: 5 4 3 2\n" + fields("", " time"),
                                                  other + little, false)));
    const auto channel = open_volume(
        write(folder / "3.nrrd",
              nrrd("dimension: 4\nsizes: 2 5 4 3\n" + fields("vector ", ""), interleaved(2, 0), false)),
        {}, {.channel = "0"});
    CHECK(same_place(frame->grid(), alone->grid()));
    CHECK(same_place(channel->grid(), alone->grid()));
    CHECK(frame->notes().world == alone->notes().world);
  }
}

TEST_CASE("NRRD axes that make no volume are refused", "[nrrd][bad]") {
  const auto with = [](const std::string& fields, std::size_t bytes = 720) {
    return nrrd(fields, std::string(bytes, 'v'), false);
  };
  check_all({
      file("time between", "lies between", "a.nrrd",
           with("dimension: 4\nsizes: 5 4 3 3\nkinds: domain domain time domain\n")),
      file("two before", "first axes", "a.nrrd",
           with("dimension: 5\nsizes: 2 3 5 4 3\nkinds: time vector domain domain domain\n")),
      file("two times", "two axes of volumes", "a.nrrd",
           with("dimension: 5\nsizes: 5 4 3 2 3\nkinds: domain domain domain time time\n")),
      file("cut short", "promises 360 bytes", "a.nrrd", with("dimension: 4\nsizes: 5 4 3 3\n", 359)),
      file("overflow", "too large", "a.nrrd",
           with("dimension: 5\nsizes: 2000000000 2000000000 1 2000000000 1\n")),
      file("64 bits", "int32, uint32 or float32", "a.nrrd",
           "NRRD0005\ntype: int64\nendian: little\nencoding: raw\ndimension: 4\nsizes: 5 4 3 2\n\n" +
               std::string(960, 'v')),
      file("text", "gzip or raw", "a.nrrd",
           "NRRD0005\ntype: short\nencoding: ascii\ndimension: 4\nsizes: 1 1 1 2\n\n1 2\n"),
  });
}

TEST_CASE("a MetaImage's fourth dimension is of frames, its channels are channels", "[meta][frames]") {
  const Folder folder;
  const auto header = [](const std::string& size, const std::string& fields, const std::string& data_file) {
    return fmt::format(
        "ObjectType = Image\nNDims = {}\nDimSize = {}\nElementType = MET_SHORT\n{}ElementDataFile = {}",
        size.size() > 5 ? 4 : 3, size, fields, data_file);
  };
  const std::string behind = other + little + other;
  const auto raw = write(folder / "a.mha", header("5 4 3 3", "", "LOCAL\n") + behind);
  const auto packed =
      write(folder / "b.mha", header("5 4 3 3", "CompressedData = True\n", "LOCAL\n") + zlib_stream(behind));
  write(folder / "c.raw", "unknown header" + behind);
  const auto last = write(folder / "c.mhd", header("5 4 3 3", "HeaderSize = -1\n", "c.raw\n"));
  for (int t = 0; t < 3; ++t)
    write(folder / fmt::format("t{}.raw", t), behind.substr(std::size_t(t) * 120, 120));
  const auto files = write(folder / "d.mhd", header("5 4 3 3", "", "t%d.raw 0 2 1\n"));
  for (int z = 0; z < 9; ++z)
    write(folder / fmt::format("s{}.raw", z), behind.substr(std::size_t(z) * 40, 40));
  const auto slices =
      write(folder / "e.mhd", header("5 4 3 3", "",
                                     "LIST 2\ns0.raw\ns1.raw\ns2.raw\ns3.raw\ns4.raw\ns5.raw\n"
                                     "s6.raw\ns7.raw\ns8.raw\n"));
  for (const auto& path : {raw, packed, last, files, slices}) {
    CAPTURE(path);
    CHECK(open_volume(path)->notes().frames == 3);
    CHECK(voxels_of(path) == other);
    CHECK((voxels_of(path, {.frame = 1}) == little));
    CHECK_THROWS_WITH(open_volume(path, {}, {.frame = 3}), Contains("holds 3 volumes"));
  }
  const std::string three = "ElementNumberOfChannels = 3\n";
  const auto vectors = write(folder / "v.mha", header("5 4 3", three, "LOCAL\n") + interleaved(3, 2));
  CHECK((voxels_of(vectors, {.channel = "2"}) == little));
  CHECK_THROWS_WITH(open_volume(vectors), Contains("vector of 3 numbers"));
  const auto both = write(folder / "f.mha", header("5 4 3 2", three + "CompressedData = True\n", "LOCAL\n") +
                                                zlib_stream(std::string(360, 'x') + interleaved(3, 0)));
  CHECK((voxels_of(both, {.frame = 1, .channel = "0"}) == little));
  const auto text =
      write(folder / "t.mha", header("1 1 1", three + "BinaryData = False\n", "LOCAL\n") + "7 8 9\n");
  CHECK(voxels_of(text, {.channel = "1"}) == bytes_of(short(8)));
}

TEST_CASE("a legacy VTK file's vectors and colours are channels", "[vtk][channels]") {
  const Folder folder;
  const auto header = [](const char* kind, const std::string& field) {
    return fmt::format(
        "# vtk DataFile Version 3.0\ntest\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\nSPACING 1 2 3\n"
        "ORIGIN 0 0 0\nPOINT_DATA 60\n{}\n",
        kind, field);
  };
  const auto data = interleaved(3, 1, true);
  for (const char* field : {"VECTORS v short", "SCALARS v short 3\nLOOKUP_TABLE default"}) {
    CAPTURE(field);
    const auto path = write(folder / "a.vtk", header("BINARY", field) + data);
    CHECK((voxels_of(path, {.channel = "1"}) == little));
    CHECK(open_volume(path, {}, {.channel = "1"})->notes().channels == 3);
    CHECK_THROWS_WITH(open_volume(path), Contains("vector of 3 numbers"));
    CHECK_THROWS_WITH(
        open_volume(write(folder / "b.vtk", header("BINARY", field) + data.substr(1)), {}, {.channel = "1"}),
        Contains("promises 360 bytes"));
  }
  std::string bytes;
  for (int i = 0; i < 60; ++i) bytes += std::string("\xff\0\0", 3);
  const auto colours = write(folder / "c.vtk", header("BINARY", "COLOR_SCALARS c 3") + bytes);
  const CapturedLog log;
  CHECK(open_volume(colours)->grid().type == ScalarType::uint8);
  CHECK(voxels_of(colours) == std::string(60, '\x36'));
  CHECK(says(log.text(), "voxels are colours"));
}

TEST_CASE("a legacy VTK file says in its header where and what it is", "[vtk]") {
  const Folder folder;
  const auto file = [&](const std::string& header, const std::string& data) {
    return open_volume(write(folder / "a.vtk", "# vtk DataFile Version 2.0\n\n" + header + data));
  };
  const std::string points = "dataset structured_points\r\nDIMENSIONS 5 4 3\r\n";
  const auto binary =
      file("BINARY\r\n" + points +
               "FIELD FieldData 1\nTIME 1 1 double\n12345678\nORIGIN 1 -2.5 3e1\n\nASPECT_RATIO 2 3 4\n"
               "POINT_DATA 60\nSCALARS values short\n",
           samples<short>(true));
  CHECK(binary->grid().spacing == glm::dvec3(2, 3, 4));
  CHECK(binary->grid().origin == glm::dvec3(1, -2.5, 30));
  CHECK((read_all(*binary) == little));
  const auto text = file("ASCII\n" + points + "COLOR_SCALARS c 1\n", text_of_samples());
  CHECK(text->grid().type == ScalarType::float32);
  CHECK(text->grid().spacing == glm::dvec3(1));
  const auto head = [](const std::string& rest) { return "# vtk DataFile Version 3.0\nt\nBINARY\n" + rest; };
  const std::string grid = "DATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n", data(480, 'v');
  check_all({
      files::file("another set", "no STRUCTURED_POINTS", "a.vtk", head("DATASET POLYDATA\n")),
      files::file("cells", "values of cells", "a.vtk", head(grid + "CELL_DATA 24\nSCALARS v short\n" + data)),
      files::file("tensors", "with SCALARS", "a.vtk", head(grid + "TENSORS t float\n")),
      files::file("64 bits", "type 'long' cannot", "a.vtk", head(grid + "SCALARS v long\n" + data)),
      files::file("no components", "'scalars v short 0'", "a.vtk", head(grid + "SCALARS v short 0\n" + data)),
      files::file("no type", "'scalars v'", "a.vtk", head(grid + "SCALARS v\n" + data)),
      files::file("two numbers", "'dimensions 5 4'", "a.vtk",
                  head("DATASET STRUCTURED_POINTS\nDIMENSIONS 5 4\nSCALARS v short\n" + data)),
      files::file("long axes", "99999999999 voxels along axis 0", "a.vtk",
                  head("DATASET STRUCTURED_POINTS\nDIMENSIONS 99999999999 1 1\nSCALARS v short\n" + data)),
      files::file("no encoding", "neither ASCII nor BINARY", "a.vtk",
                  "# vtk DataFile Version 3.0\nt\n" + grid + "SCALARS v short\n" + data),
  });
}

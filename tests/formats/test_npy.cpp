#include <fmt/format.h>

#include "formats/bad_files.hpp"
#include "formats/captured_log.hpp"
#include "formats/npy.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"

using namespace files;
using Catch::Matchers::Contains;

TEST_CASE("a NumPy array of z, y, x is read in all formats, types and byte orders", "[npy]") {
  const Folder folder;
  for (const int version : {1, 2, 3}) {
    const auto source =
        open_volume(write(folder / "a.npy", npy("<i2", "(3, 4, 5)", version) + samples<short>()));
    CHECK(source->grid().spacing == glm::dvec3(1));
    CHECK(source->concurrent());
    CHECK(is_sample(*source));
  }
  const std::pair<ScalarType, std::string> names[] = {
      {ScalarType::int8, "i1"},    {ScalarType::uint8, "u1"},  {ScalarType::int16, "i2"},
      {ScalarType::uint16, "u2"},  {ScalarType::int32, "i4"},  {ScalarType::uint32, "u4"},
      {ScalarType::float32, "f4"}, {ScalarType::float64, "f8"}};
  for (const auto& [type, name] : names)
    for (const bool big : {false, true}) {
      CAPTURE(name, big);
      const auto file = npy((big ? ">" : "<") + name, "(3, 4, 5)") + samples_of(type, big);
      const auto source = open_volume(write(folder / "a.npy", file));
      CHECK(source->grid().type == type);
      CHECK((read_all(*source) == samples_of(type)));
    }
}

TEST_CASE("a NumPy header may be spelt as other writers do", "[npy]") {
  const Folder folder;
  for (const char* text : {"{'descr': '<i2', 'fortran_order': False, 'shape': (3, 4, 5), }          \n",
                           "{\"shape\":(3L,4L,5L),\"descr\":\"<i2\",\"fortran_order\":False}",
                           "  { 'fortran_order' : False , 'shape' : ( 3 , 4 , 5 , ) , 'descr' : '<i2' } "}) {
    CAPTURE(text);
    CHECK((voxels_of(write(folder / "a.npy", npy_of_text(text) + samples<short>())) == samples<short>()));
  }
}

TEST_CASE("of a NumPy array in Fortran order the first axis lies along z", "[npy]") {
  const Folder folder;
  for (const bool big : {false, true}) {
    const auto source = open_volume(
        write(folder / "a.npy", npy(big ? ">i2" : "<i2", "(5, 4, 3)", 1, true) + samples<short>(big)));
    CHECK(source->grid().dims == glm::ivec3(nx, ny, nz));
    CHECK(source->grid().direction == glm::dmat3(0, 0, 1, 0, 1, 0, 1, 0, 0));
    CHECK(source->concurrent());
    CHECK((read_all(*source) == samples<short>()));
  }
}

TEST_CASE("NumPy's float16 becomes float32, its bool uint8", "[npy]") {
  const Folder folder;
  // IEEE 754-2008, binary16: 1, -2, the smallest, 65504, infinity, 1/3 rounded; then the negative ones
  // nearest to zero, with the most digits below the smallest normal one, the largest and infinity; both
  // smallest normal ones.
  const std::uint16_t halves[] = {0x3C00, 0xC000, 0x0001, 0x7BFF, 0x7C00, 0x3555,
                                  0x8001, 0x83FF, 0xFBFF, 0xFC00, 0x0400, 0x8400};
  for (const bool big : {false, true}) {
    std::string data;
    for (const auto half : halves) data += bytes_of(half, big);
    const auto source = open_volume(write(folder / "a.npy", npy(big ? ">f2" : "<f2", "(2, 2, 3)") + data));
    REQUIRE(source->grid().type == ScalarType::float32);
    const auto bytes = read_all(*source);
    std::vector<float> values(12);
    std::memcpy(values.data(), bytes.data(), bytes.size());
    CHECK((values == std::vector<float>{1, -2, 0x1p-24F, 65504, INFINITY, 0x1.554p-2F, -0x1p-24F,
                                        -0x1.ff8p-15F, -65504, -INFINITY, 0x1p-14F, -0x1p-14F}));
    CHECK(read_slice(*source, 1) == bytes.substr(24));
  }
  const auto mask = open_volume(write(folder / "a.npy", npy("|b1", "(1, 1, 3)") + std::string("\1\0\1", 3)));
  CHECK(mask->grid().type == ScalarType::uint8);
  CHECK(read_all(*mask) == std::string("\1\0\1", 3));
}

TEST_CASE("a NumPy array of two axes is one slice", "[npy]") {
  const Folder folder;
  const auto source = open_volume(write(folder / "a.npy", npy("|u1", "(2, 3)") + "abcdef"));
  CHECK(source->grid().dims == glm::ivec3(3, 2, 1));
  CHECK(read_all(*source) == "abcdef");
}

TEST_CASE("a NumPy array's leading axis is of frames, a short last one of channels", "[npy]") {
  const Folder folder;
  const auto other = std::string(120, 'x');
  const auto frames = write(folder / "t.npy", npy("<i2", "(2, 3, 4, 5)") + other + samples<short>());
  CHECK(open_volume(frames)->notes().frames == 2);
  CHECK(voxels_of(frames) == other);
  CHECK((voxels_of(frames, {.frame = 1}) == samples<short>()));
  CHECK_THROWS_WITH(open_volume(frames, {}, {.frame = 2}), Contains("--frame 2") && Contains("2 volumes"));

  const auto channels = write(folder / "c.npy", npy("<i2", "(3, 4, 5, 3)") + interleaved(3, 1));
  CHECK((voxels_of(channels, {.channel = "1"}) == samples<short>()));
  CHECK(open_volume(channels, {}, {.channel = "1"})->notes().channels == 3);
  CHECK_THROWS_WITH(open_volume(channels), Contains("vector of 3 numbers") && Contains("--channel"));

  const auto both =
      write(folder / "b.npy", npy("<i2", "(2, 3, 4, 5, 3)") + std::string(360, 'x') + interleaved(3, 1));
  CHECK((voxels_of(both, {.frame = 1, .channel = "1"}) == samples<short>()));

  const auto single = write(folder / "s.npy", npy("<i2", "(1, 3, 4, 5, 1)") + samples<short>());
  CHECK((voxels_of(single) == samples<short>()));
}

TEST_CASE("a NumPy array of colours is shown by its luminance, with a warning", "[npy]") {
  const Folder folder;
  const auto path =
      write(folder / "colours.npy", npy("|u1", "(1, 1, 2, 3)") + std::string("\xff\0\0\7\7\7", 6));
  const CapturedLog log;
  CHECK(voxels_of(path) == "\x36\7");
  CHECK(says(log.text(), "colours.npy: voxels are colours"));
  CHECK(voxels_of(path, {.channel = "b"}) == std::string("\0\7", 2));
}

TEST_CASE("NumPy files that are damaged or cannot be a volume are refused", "[npy][bad]") {
  const auto voxels = samples<short>();
  const auto text = [&](const std::string& header) { return npy_of_text(header) + voxels; };
  check_all({
      file("empty", "no NumPy array file", "a.npy", ""),
      file("other magic", "no NumPy array file", "a.npy", "\x93NUMPX\1" + std::string(200, '\0')),
      file("format 9", "no NumPy array file of format 1 to 3", "a.npy", npy("<i2", "(3, 4, 5)", 9) + voxels),
      file("header cut", "cut short", "a.npy", npy("<i2", "(3, 4, 5)").substr(0, 40)),
      file("endless header", "cut short or endless", "a.npy",
           std::string("\x93NUMPY\2\0\xff\xff\xff\x7f", 12) + std::string(300, ' ')),
      file("voxels cut", "promises 120 bytes of voxels, the file holds 119", "a.npy",
           npy("<i2", "(3, 4, 5)") + voxels.substr(1)),
      file("frames cut", "promises 240 bytes of voxels, the file holds 120", "a.npy",
           npy("<i2", "(2, 3, 4, 5)") + voxels),
      file("overflowing", "overflow 64 bits", "a.npy",
           npy("<i2", "(2147483647, 2147483647, 2147483647)") + voxels),
      file("overflowing frames", "2147483647 volumes of 10000000000000 bytes overflow", "a.npy",
           npy("<i2", "(2147483647, 1000000, 1000000, 5)") + voxels),
      file("too large an axis", "(4294967296, 4, 5)", "a.npy", npy("<i2", "(4294967296, 4, 5)") + voxels),
      file("no voxels", "(3, 0, 5)", "a.npy", npy("<i2", "(3, 0, 5)") + voxels),
      file("one axis", "has the shape (60)", "a.npy", npy("<i2", "(60,)") + voxels),
      file("six axes", "has the shape", "a.npy", npy("<i2", "(1, 1, 1, 3, 4, 5)") + voxels),
      file("five axes without components", "has the shape", "a.npy", npy("<i2", "(1, 1, 3, 4, 5)") + voxels),
      file("frames in Fortran order", "np.ascontiguousarray(a)", "a.npy",
           npy("<i2", "(1, 3, 4, 5)", 1, true) + voxels),
      file("Fortran order, cut", "promises 120 bytes", "a.npy",
           npy("<i2", "(3, 4, 5)", 1, true) + voxels.substr(1)),
      file("64 bits", "type '<i8' cannot", "a.npy", npy("<i8", "(3, 4, 5)") + voxels),
      file("complex", "type '<c8' cannot", "a.npy", npy("<c8", "(3, 4, 5)") + voxels),
      file("objects", "type '|O' cannot", "a.npy", npy("|O", "(3, 4, 5)") + voxels),
      file("empty type", "type '' cannot", "a.npy", npy("", "(3, 4, 5)") + voxels),
      file("fields", "named fields", "a.npy",
           text("{'descr': [('a', '<i2')], 'fortran_order': False, 'shape': (3, 4, 5)}")),
      file("no dictionary", "no readable NumPy header", "a.npy", text("hello")),
      file("no shape", "no readable NumPy header", "a.npy", text("{'descr': '<i2', 'fortran_order': False}")),
      file("shape twice", "no readable NumPy header", "a.npy", text("{'shape': (3,), 'shape': (3,)}")),
      file("negative size", "no readable NumPy header", "a.npy", npy("<i2", "(3, -4, 5)") + voxels),
      file("size beyond 64 bits", "no readable NumPy header", "a.npy",
           npy("<i2", "(99999999999999999999,)") + voxels),
      file("maybe", "no readable NumPy header", "a.npy", text("{'fortran_order': Maybe}")),
      file("text without an end", "no readable NumPy header", "a.npy", text("{'descr")),
      file("unknown key", "no readable NumPy header", "a.npy", text("{'more': 1}")),
      file("more behind", "no readable NumPy header", "a.npy",
           text("{'descr': '<i2', 'fortran_order': False, 'shape': (3, 4, 5)} x")),
      file("npz", "archive of arrays", "a.npz", "PK\3\4" + voxels),
  });
}

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "formats/bad_files.hpp"
#include "formats/captured_log.hpp"
#include "formats/nifti2.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"

using namespace files;
using Catch::Matchers::Contains;

namespace {

bool same_place(const Grid& a, const Grid& b) {
  for (const glm::dvec3 voxel :
       {glm::dvec3(0), glm::dvec3(4, 0, 0), glm::dvec3(0, 3, 0), glm::dvec3(0, 0, 2)})
    if (glm::distance(world(a, voxel), world(b, voxel)) > 1e-5 * glm::length(a.spacing)) return false;
  return glm::distance(a.spacing, b.spacing) < 1e-6 * glm::length(a.spacing);
}

const std::string little = samples<short>(), other(120, 'x');

}  // namespace

TEST_CASE("NIfTI-2 is read in one file, compressed, as a pair, in both byte orders", "[nifti]") {
  const Folder folder;
  Nifti2 pair;
  pair.magic = "ni2";
  pair.offset = 0;
  write(folder / "p.img", little);
  const auto header = write(folder / "p.hdr", pair.header());
  write(folder / "q.hdr", pair.header());
  const auto packed = write(folder / "q.img.gz", gzip(little));
  for (const auto& path :
       {write(folder / "a.nii", Nifti2().header() + little),
        write(folder / "b.nii", Nifti2().header(true) + samples<short>(true)),
        write(folder / "c.nii.gz", gzip(Nifti2().header() + little)), header, folder / "p.img", packed}) {
    CAPTURE(path);
    const auto source = open_volume(path);
    CHECK(source->concurrent() == !path.string().ends_with(".gz"));
    CHECK(source->notes().world == World::patient);
    CHECK(source->notes().unit == "mm");
    CHECK(is_sample(*source));
  }
}

TEST_CASE("NIfTI-2 lies where the same NIfTI-1 lies", "[nifti][orientation]") {
  std::vector<Nifti2> headers(8);
  headers[1].sform = 0, headers[1].qform = 1;
  headers[1].quaternion[2] = 0.6, headers[1].shift[0] = 5, headers[1].shift[1] = -6, headers[1].shift[2] = 7;
  headers[2] = headers[1];
  headers[2].spacing[0] = -1, headers[2].quaternion[0] = 0.3, headers[2].quaternion[1] = -0.5;
  headers[3] = headers[1];
  headers[3].quaternion[0] = 1, headers[3].quaternion[2] = 0;  // half a turn
  headers[4].sform = headers[4].qform = 0;
  const double turned[] = {0, -2, 0, 5, 0, 0, 3, 6, 1, 0, 0, 7};
  std::copy(turned, turned + 12, headers[5].rows);
  headers[6].qform = 1, headers[6].quaternion[1] = 1;  // the sform comes first
  const double sheared[] = {1, 0, 0.5, 5, 0, 2, 0, 6, 0, 0, 3, 7};
  std::copy(sheared, sheared + 12, headers[7].rows);
  const Folder folder;
  for (std::size_t i = 0; i < headers.size(); ++i)
    for (const int units : {0, 1, 2, 3}) {
      auto header = headers[i];
      header.units = units;
      CAPTURE(i, units);
      const auto one = open_volume(write(folder / "1.nii", header.header_of_nifti1() + little));
      const auto two = open_volume(write(folder / "2.nii", header.header() + little));
      CHECK(same_place(one->grid(), two->grid()));
      const double unit = units == 1 ? 1e3 : units == 3 ? 1e-3 : 1;
      CHECK(two->grid().spacing.x == Approx(unit));
      CHECK(two->notes().unit == "mm");
    }
}

TEST_CASE("a sheared sform is kept, whatever the qform says", "[nifti][orientation]") {
  Nifti2 header;
  header.qform = 1, header.sform = 4;
  const double rows[] = {1, 0.1, 0.5, 5, 0, 2, -0.25, 6, 0.05, 0, 3, 7};
  std::copy(rows, rows + 12, header.rows);
  const Folder folder;
  for (const bool version_2 : {false, true}) {
    const auto source = open_volume(
        write(folder / "a.nii", (version_2 ? header.header() : header.header_of_nifti1()) + little));
    const glm::dvec3 voxel(3, 2, 1);
    glm::dvec3 expected;
    for (int row = 0; row < 3; ++row)
      expected[row] = rows[4 * row] * 3 + rows[4 * row + 1] * 2 + rows[4 * row + 2] + rows[4 * row + 3];
    CAPTURE(version_2);
    CHECK(glm::distance(world(source->grid(), voxel), expected * glm::dvec3(-1, -1, 1)) < 1e-5);
  }
}

TEST_CASE("NIfTI-1's pairs and Analyze's are read by either file's name", "[nifti]") {
  const Folder folder;
  Nifti pair;
  pair.magic = "ni1";
  pair.offset = 0;
  Nifti analyze = pair;
  analyze.magic = "\0\0\0";
  analyze.slope = 2;  // Analyze has other things there
  for (const auto& header : {pair, analyze}) {
    write(folder / "a.hdr", header.header().substr(0, 348));
    write(folder / "a.img", little);
    write(folder / "b.hdr", header.header().substr(0, 348));
    write(folder / "b.img.gz", gzip(little));
    write(folder / "C.HDR", header.header(true).substr(0, 348));
    write(folder / "C.IMG", samples<short>(true));
    for (const char* name : {"a.hdr", "a.img", "b.hdr", "b.img.gz", "C.HDR", "C.IMG"}) {
      CAPTURE(name, header.magic);
      const auto source = open_volume(folder / name);
      CHECK((read_all(*source) == little));
      CHECK(source->grid().spacing == glm::dvec3(1, 2, 3));
      // Analyze knows no world.
      CHECK(source->grid().origin == (header.magic[0] == 'n' ? glm::dvec3(10, 20, -30) : glm::dvec3(0)));
    }
  }
  // A header that says it is one of a pair, before its voxels.
  pair.offset = 352;
  CHECK((voxels_of(write(folder / "d.nii", pair.header() + little)) == little));
}

TEST_CASE("a NIfTI-1's qform has its header's spacing exactly", "[nifti][orientation]") {
  const Folder folder;
  Nifti2 turned;
  turned.sform = 0, turned.qform = 1;
  turned.quaternion[0] = 0.1, turned.quaternion[1] = -0.2, turned.quaternion[2] = 0.3;
  turned.spacing[1] = 0.7;
  const auto grid = open_volume(write(folder / "a.nii", turned.header_of_nifti1() + little))->grid();
  CHECK(grid.spacing == glm::dvec3(double(0.7F), 2, 3));
  for (int axis = 0; axis < 3; ++axis) CHECK(glm::length(grid.direction[axis]) == Approx(1));
}

TEST_CASE("NIfTI slope and intercept are applied", "[nifti]") {
  Nifti2 scaled;
  scaled.slope = 0.5, scaled.intercept = -3;
  const Folder folder;
  for (const auto& header : {scaled.header(), scaled.header_of_nifti1()}) {
    const auto source = open_volume(write(folder / "a.nii", header + little));
    REQUIRE(source->grid().type == ScalarType::float32);
    CHECK(source->concurrent());
    const auto bytes = read_slice(*source, 1);
    const auto* values = reinterpret_cast<const float*>(bytes.data());
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) CHECK(values[y * nx + x] == float(sample<short>(x, y, 1)) * 0.5F - 3);
  }
}

TEST_CASE("a NIfTI's time points are frames, its further axes channels", "[nifti]") {
  const Folder folder;
  Nifti2 four, five;
  four.dims[0] = 4, four.dims[4] = 3;
  five.dims[0] = 5, five.dims[4] = 2, five.dims[5] = 3;
  const auto frames = other + little + other;
  // All frames of a component follow those of the one before.
  const auto vectors = other + other + other + little + other + other;
  for (const bool version_2 : {false, true}) {
    const auto header = [&](const Nifti2& n) { return version_2 ? n.header() : n.header_of_nifti1(); };
    for (const bool packed : {false, true}) {
      CAPTURE(version_2, packed);
      const auto save = [&](const std::string& name, const std::string& bytes) {
        return packed ? write(folder / (name + ".nii.gz"), gzip(bytes))
                      : write(folder / (name + ".nii"), bytes);
      };
      const auto path = save("t", header(four) + frames);
      CHECK(open_volume(path)->notes().frames == 3);
      CHECK(voxels_of(path) == other);
      CHECK((voxels_of(path, {.frame = 1}) == little));
      const auto second = open_volume(path, {}, {.frame = 1});
      for (const int z : {2, 0, 1}) CHECK((read_slice(*second, z) == slice_of_samples(z)));
      CHECK(same_place(second->grid(), open_volume(save("o", header(Nifti2()) + little))->grid()));
      CHECK_THROWS_WITH(open_volume(path, {}, {.frame = 3}), Contains("holds 3 volumes"));

      const auto vector = save("v", header(five) + vectors);
      CHECK((voxels_of(vector, {.frame = 1, .channel = "1"}) == little));
      CHECK(voxels_of(vector, {.frame = 0, .channel = "1"}) == other);
      CHECK(open_volume(vector, {}, {.channel = "0"})->notes().channels == 3);
      CHECK_THROWS_WITH(open_volume(vector), Contains("vector of 3 numbers") && Contains("from 0 to 2"));
    }
  }
}

TEST_CASE("a NIfTI of colours is shown by its luminance, with a warning", "[nifti]") {
  const Folder folder;
  for (const bool version_2 : {false, true}) {
    Nifti2 rgb;
    rgb.dims[0] = 4, rgb.dims[1] = 2, rgb.dims[2] = rgb.dims[3] = 1, rgb.dims[4] = 2;
    rgb.datatype = 128;
    auto head = version_2 ? rgb.header() : rgb.header_of_nifti1();
    if (!version_2) head[72] = 24;
    const auto path = write(folder / fmt::format("rgb{}.nii", version_2),
                            head + "abcdef" + std::string("\xff\0\0\7\7\7", 6));
    const CapturedLog log;
    CHECK(voxels_of(path, {.frame = 1}) == "\x36\7");
    CHECK(says(log.text(), "voxels are colours"));
    CHECK(voxels_of(path, {.channel = "g"}) == "be");
    CHECK(open_volume(path)->notes().frames == 2);
    rgb.datatype = 2304;
    rgb.dims[4] = 1;
    head = version_2 ? rgb.header() : rgb.header_of_nifti1();
    if (!version_2) head[72] = 32;
    const auto rgba = write(folder / fmt::format("rgba{}.nii", version_2), head + "abcdefgh");
    CHECK(voxels_of(rgba, {.channel = "a"}) == "dh");
  }
}

TEST_CASE("bad NIfTI-2 files are clear errors", "[nifti][bad]") {
  const auto with = [](auto change) {
    Nifti2 header;
    change(header);
    return header.header() + samples<short>();
  };
  auto no_signature = Nifti2().header();
  no_signature[8] = 'x';
  constexpr auto endless = std::numeric_limits<double>::infinity();
  check_all({
      file("cut short", "promises 120 bytes", "a.nii", Nifti2().header() + "short"),
      file("header cut short", "the header is cut short", "a.nii", Nifti2().header().substr(0, 500)),
      file("gzip cut short", "cut short or damaged", "a.nii.gz",
           gzip(Nifti2().header() + samples<short>()).substr(0, 150)),
      file("signature", "not NIfTI-2's signature", "a.nii", no_signature + samples<short>()),
      file("no dimensions", "dim[0] is 0", "a.nii", with([](Nifti2& h) { h.dims[0] = 0; })),
      file("eight dimensions", "dim[0] is 8", "a.nii", with([](Nifti2& h) { h.dims[0] = 8; })),
      file("zero", "dim[2] is 0", "a.nii", with([](Nifti2& h) { h.dims[2] = 0; })),
      file("negative", "dim[3] is -3", "a.nii", with([](Nifti2& h) { h.dims[3] = -3; })),
      file("beyond int", "dim[1] is 4294967296", "a.nii", with([](Nifti2& h) { h.dims[1] = 1LL << 32; })),
      file("overflow", "overflow 64 bits", "a.nii",
           with([](Nifti2& h) { h.dims[1] = h.dims[2] = h.dims[3] = 2000000000; })),
      file("overflowing frames", "overflow 64 bits", "a.nii",
           with([](Nifti2& h) { h.dims[0] = 4, h.dims[1] = h.dims[2] = h.dims[4] = 2000000000; })),
      file("overflowing vectors", "axes 5 to 7", "a.nii",
           with([](Nifti2& h) { h.dims[0] = 7, h.dims[5] = h.dims[6] = h.dims[7] = 2000000000; })),
      file("unknown type", "type 77 cannot", "a.nii", with([](Nifti2& h) { h.datatype = 77; })),
      file("64 bits", "int32, uint32 or float32", "a.nii", with([](Nifti2& h) { h.datatype = 1024; })),
      file("infinite row", "is not a number", "a.nii", with([](Nifti2& h) { h.rows[0] = endless; })),
      file("infinite spacing", "is not a number", "a.nii", with([](Nifti2& h) { h.spacing[2] = endless; })),
      file("negative spacing", "pixdim[2] is -3", "a.nii",
           with([](Nifti2& h) { h.sform = 0, h.spacing[2] = -3; })),
      file("singular", "leads nowhere", "a.nii", with([](Nifti2& h) { h.rows[10] = 0; })),
      file("offset in the header", "vox_offset is 100", "a.nii", with([](Nifti2& h) { h.offset = 100; })),
      file("negative offset", "vox_offset is -1", "a.nii", with([](Nifti2& h) { h.offset = -1; })),
      file("far offset", "vox_offset is", "a.nii", with([](Nifti2& h) { h.offset = 1LL << 62; })),
      file("no image", "b.img", "b.hdr", with([](Nifti2& h) { h.magic = "ni2", h.offset = 0; })),
  });
}

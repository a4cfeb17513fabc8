#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "formats/bad_files.hpp"
#include "formats/captured_log.hpp"
#include "formats/files.hpp"
#include "support/catch.hpp"

using namespace files;

namespace {

struct Pages {
  int count = 1;
  std::string description = {};
  float resolution = 0;  ///< pixels a unit; those along y are twice as many
  int samples = 1;
  const char* compression = "none";
};

/// Writes pages of 4 x 3 pixels: 'a' everywhere in the first, 'b' in the second and so on, one more in each
/// further sample.
fs::path write_pages(const fs::path& path, const Pages& pages) {
  OIIO::ImageSpec spec(4, 3, pages.samples, OIIO::TypeDesc::UINT8);
  auto out = OIIO::ImageOutput::create(path.string());
  for (int i = 0; i < pages.count; ++i) {
    std::string pixels;
    for (int k = 0; k < 4 * 3 * pages.samples; ++k) pixels += char('a' + i + k % pages.samples);
    spec.extra_attribs.clear();
    if (i == 0) spec.attribute("ImageDescription", pages.description);
    if (pages.resolution > 0) spec.attribute("XResolution", pages.resolution);
    if (pages.resolution > 0) spec.attribute("PixelAspectRatio", 2.0F);
    spec.attribute("Compression", pages.compression);
    REQUIRE(out->open(path.string(), spec,
                      i == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage));
    REQUIRE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  }
  out->close();
  return path;
}

fs::path write_pages(const fs::path& path, int pages, const std::string& description, float resolution = 0) {
  return write_pages(path, {.count = pages, .description = description, .resolution = resolution});
}

/// The letter of each slice's page.
std::string letters_of(VolumeSource& source) {
  std::string letters;
  for (int z = 0; z < source.grid().dims.z; ++z) {
    const auto slice = read_slice(source, z);
    CHECK(slice == std::string(slice.size(), slice[0]));
    letters += slice[0];
  }
  return letters;
}

std::string letters_of(const fs::path& path, int frame, const std::string& channel) {
  return letters_of(*open_volume(path, {}, {.frame = frame, .channel = channel}));
}

std::string image_j(const std::string& lines) {
  return "ImageJ=1.53t\n" + lines + "loop=false\nmin=0.0\nmax=255.0\n";
}

std::string ome(const std::string& pixels, const std::string& inside = {}) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?><!-- a > b --><OME "
         "xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image ID=\"Image:0\"><Pixels "
         "ID=\"Pixels:0\" "
         "Type=\"uint8\" SizeX=\"4\" SizeY=\"3\" " +
         pixels + ">" + inside + "</Pixels></Image></OME>";
}

Bad pages(const char* what, const char* message, int count, const std::string& description) {
  return {what, message, [=](const Folder& f) { return write_pages(f / "a.tif", count, description); }};
}

const char* const not_there =
    "it is cut short or damaged: a page, or a part of one, is not where it should be";

/// Little-endian, of 2 or 4 bytes.
std::uint32_t number_at(const std::string& bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  std::memcpy(&value, &bytes[at], size);
  return value;
}

std::string file_uuid(const std::string& name) {
  return "<TiffData IFD=\"0\"><UUID FileName=\"" + name + "\">urn:uuid:1</UUID></TiffData>";
}

}  // namespace

TEST_CASE("pages that a description does not account for are refused", "[tiff][bad]") {
  check_all({
      pages("ImageJ channels",
            "it has 2 channels, 1 time points and 3 slices (by its ImageJ), and has 5 pages", 5,
            image_j("images=6\nchannels=2\nslices=3\nhyperstack=true\nmode=composite\n")),
      pages("ImageJ slices in one page", "it has 300 slices (by its ImageJ), and has 1 pages", 1,
            image_j("images=300\nslices=300\n")),
      pages("ImageJ, images only", "it has 5 slices", 4, image_j("images=5\n")),
      pages("ImageJ, more than any file holds", "4611686018427387904 slices", 4,
            image_j("channels=4\nframes=4\nslices=4611686018427387904\n")),
      pages("ImageJ, negative", "-2 channels", 4, image_j("channels=-2\nframes=-2\nslices=1\n")),
      pages("OME channels", "it has 2 channels, 1 time points and 3 slices (by its OME-XML), and has 7 pages",
            7, ome("SizeC=\"2\" SizeZ=\"3\" SizeT=\"1\" DimensionOrder=\"XYCZT\"")),
      pages("OME slices elsewhere", "it has 9 slices", 3, ome("SizeC=\"1\" SizeZ=\"9\" SizeT=\"1\"")),
      pages("OME without a size", "SizeC, SizeT or SizeZ is missing", 3, ome("SizeC=\"1\" SizeZ=\"3\"")),
      pages("OME in no order", "DimensionOrder is 'XYCCT'", 6,
            ome("SizeC=\"2\" SizeZ=\"3\" SizeT=\"1\" DimensionOrder=\"XYCCT\"")),
      pages("OME plane outside", "TiffData element lies outside", 2,
            ome("SizeC='1' SizeZ='2' SizeT='1' DimensionOrder='XYZCT'", "<TiffData IFD='0' FirstZ='2'/>")),
      pages(
          "OME plane missing", "slice 1 of channel 0 at time 0 is not in the file", 2,
          ome("SizeC='1' SizeZ='2' SizeT='1' DimensionOrder='XYZCT'", "<TiffData IFD='0' PlaneCount='1'/>")),
      pages(
          "OME page missing", "slice 0 of channel 0 at time 0 is not in the file", 2,
          ome("SizeC='1' SizeZ='2' SizeT='1' DimensionOrder='XYZCT'", "<TiffData IFD='7' PlaneCount='2'/>")),
      pages("OME of several files", "it is one of 2 files", 3,
            ome("SizeC=\"1\" SizeZ=\"3\" SizeT=\"1\"", file_uuid("a.ome.tif") + file_uuid("b.ome.tif"))),
      pages("OME in another file", "another file, all.companion.ome", 3,
            "<OME><BinaryOnly MetadataFile=\"all.companion.ome\" UUID=\"urn:uuid:2\"/></OME>"),
      pages("OME of several images", "it holds 2 images", 2,
            "<ome:OME xmlns:ome='x'><ome:Image><ome:Pixels SizeC='1' SizeZ='1' SizeT='1'/></ome:Image>"
            "<ome:Image><ome:Pixels SizeC='1' SizeZ='1' SizeT='1'/></ome:Image></ome:OME>"),
      pages("OME cut short", "holds 0 images", 2, "<OME><Image><Pix"),
  });
}

TEST_CASE("ImageJ's pages run through channels, slices and time points in this order", "[tiff]") {
  const Folder folder;
  const auto path =
      write_pages(folder / "h.tif", 12,
                  image_j("images=12\nchannels=2\nslices=3\nframes=2\nhyperstack=true\nmode=composite\n"));
  CHECK(letters_of(path, 0, "0") == "ace");
  CHECK(letters_of(path, 0, "1") == "bdf");
  CHECK(letters_of(path, 1, "0") == "gik");
  CHECK(letters_of(path, 1, "1") == "hjl");
  const auto notes = open_volume(path)->notes();
  CHECK(notes.channels == 2);
  CHECK(notes.frames == 2);
  CHECK(letters_of(write_pages(folder / "t.tif", 4, image_j("images=4\nframes=4\n")), 2, "") == "c");
}

TEST_CASE("OME's pages run in the order that the file says", "[tiff]") {
  const Folder folder;
  const auto letters = [&](const std::string& order, const std::string& inside = {}) {
    const auto path =
        write_pages(folder / "a.ome.tif", 12,
                    ome("SizeC=\"2\" SizeZ=\"3\" SizeT=\"2\" DimensionOrder=\"" + order + "\"", inside));
    return letters_of(path, 0, "0") + ' ' + letters_of(path, 1, "1");
  };
  CHECK(letters("XYZCT") == "abc jkl");
  CHECK(letters("XYZTC") == "abc jkl");
  CHECK(letters("XYCZT") == "ace hjl");
  CHECK(letters("XYCTZ") == "aei dhl");
  CHECK(letters("XYTCZ") == "aei dhl");
  CHECK(letters("XYTZC") == "ace hjl");
  CHECK(letters("XYZCT", "<TiffData/>") == "abc jkl");
  CHECK(letters("XYZCT", "<TiffData IFD='0' PlaneCount='12'/>") == "abc jkl");
  // The second time point is first in the file.
  CHECK(letters("XYZCT", "<TiffData FirstT='1' IFD='0' PlaneCount='6'/><TiffData IFD='6' PlaneCount='6'/>") ==
        "ghi def");
  std::string backwards;
  for (int p = 0; p < 12; ++p)
    backwards +=
        fmt::format("<TiffData FirstZ='{}' FirstC='{}' FirstT='{}' IFD='{}'><UUID>u</UUID></TiffData>", p % 3,
                    p / 3 % 2, p / 6, 11 - p);
  CHECK(letters("XYZCT", backwards) == "lkj cba");
}

TEST_CASE("OME's channels are taken by name, and the first with a warning", "[tiff]") {
  const Folder folder;
  const auto path = write_pages(folder / "a.ome.tif", 4,
                                ome("SizeC=\"2\" SizeZ=\"2\" SizeT=\"1\" DimensionOrder=\"XYCZT\"",
                                    "<!-- <Channel Name='none'/> --><Channel ID=\"Channel:0\" "
                                    "SamplesPerPixel=\"1\" Name=\"DAPI &gt; 1\"/>"
                                    "<Channel ID=\"Channel:1\" Name=\"GFP\"><LightPath/></Channel>"));
  CHECK(letters_of(path, 0, "gfp") == "bd");
  CHECK(letters_of(path, 0, "DAPI > 1") == "ac");
  const CapturedLog log;
  CHECK(letters_of(*open_volume(path)) == "ac");
  CHECK(says(log.text(), "of the channels 0 (DAPI > 1), 1 (GFP) the first is shown"));
  CHECK(says(message_of([&] { letters_of(path, 0, "RFP"); }),
             "has no such channel; hint: its channels are 0 (DAPI > 1), 1 (GFP)"));
  CHECK(says(message_of([&] { letters_of(path, 0, "2"); }), "has no such channel"));
  CHECK(says(message_of([&] { letters_of(path, 1, "0"); }),
             "--frame 1: " + path.string() + " holds one volume"));
}

TEST_CASE("a stack lies as microscopes' programs show it", "[tiff]") {
  const Folder folder;
  const auto source = open_volume(write_pages(folder / "a.tif", 2, "plain"));
  CHECK(source->notes().world == World::microscope);
  CHECK(source->notes().unit.empty());
  // The default camera looks along y, z is up.
  CHECK(source->grid().direction[0] == glm::dvec3(1, 0, 0));
  CHECK(source->grid().direction[1] == glm::dvec3(0, 0, -1));
  CHECK(source->grid().direction[2] == glm::dvec3(0, 1, 0));
}

TEST_CASE("a microscope's voxels have the size that it tells, in micrometres", "[tiff]") {
  const Folder folder;
  const auto check = [](const fs::path& path, const glm::dvec3& spacing, const char* unit) {
    CAPTURE(path);
    const CapturedLog log;
    const auto source = open_volume(path);
    for (int i = 0; i < 3; ++i) CHECK(std::abs(source->grid().spacing[i] / spacing[i] - 1) < 1e-6);
    CHECK(source->notes().unit == unit);
    return log.text();
  };
  const auto image = [&](const char* name, const std::string& lines) {
    return write_pages(folder / name, 3, image_j("images=3\nslices=3\n" + lines), 4);
  };
  CHECK(check(image("1.tif", "unit=\\u00B5m\nspacing=1.5\n"), {0.25, 0.125, 1.5}, "um").empty());
  CHECK(check(image("2.tif", "unit=nm\nspacing=-200\n"), {0.00025, 0.000125, 0.2}, "um").empty());
  CHECK(check(image("3.tif", "unit=furlong\nspacing=2\n"), {0.25, 0.125, 2}, "furlong").empty());
  CHECK(check(image("4.tif", "spacing=2\n"), {1, 1, 2}, "").empty());
  CHECK(check(image("5.tif", "unit=pixel\n"), {1, 1, 1}, "").empty());
  CHECK(says(check(image("6.tif", "unit=micron\n"), {0.25, 0.125, 1}, "um"),
             "the distance of slices is missing (by its ImageJ) and taken for 1 um, as ImageJ does"));
  CHECK(says(check(image("7.tif", "unit=um\nspacing=1e9\n"), {0.25, 0.125, 0.25}, "um"),
             "the distance of slices is 1e+09 um (by its ImageJ) and taken for 0.25 um, as of columns"));
  const auto xml = [&](const char* name, const std::string& sizes) {
    return write_pages(folder / name, 2,
                       ome("SizeC=\"1\" SizeZ=\"2\" SizeT=\"1\" DimensionOrder=\"XYZCT\" " + sizes,
                           file_uuid("its old name")));
  };
  const std::string xy = "PhysicalSizeX=\"0.2\" PhysicalSizeY=\"0.3\" ";
  CHECK(
      check(xml("1.ome.tif", xy + "PhysicalSizeZ=\"2\" PhysicalSizeXUnit=\"\xC2\xB5m\""), {0.2, 0.3, 2}, "um")
          .empty());
  CHECK(check(xml("2.ome.tif", xy + "PhysicalSizeZ=\"2\""), {0.2, 0.3, 2}, "um").empty());
  CHECK(
      check(xml("3.ome.tif", xy + "PhysicalSizeZ='2000' PhysicalSizeZUnit='nm' PhysicalSizeYUnit='&#181;m'"),
            {0.2, 0.3, 2}, "um")
          .empty());
  CHECK(says(check(xml("4.ome.tif", xy), {0.2, 0.3, 0.2}, "um"),
             "the distance of slices is missing (by its OME-XML) and taken for 0.2 um, as of columns"));
  CHECK(check(xml("5.ome.tif", xy + "PhysicalSizeZ='3' PhysicalSizeXUnit='pixel' PhysicalSizeYUnit='pixel' "
                                    "PhysicalSizeZUnit='pixel'"),
              {0.2, 0.3, 3}, "")
            .empty());
  // The micro sign in Latin-1, which is no UTF-8.
  CHECK(check(xml("7.ome.tif", xy + "PhysicalSizeZ='2' PhysicalSizeXUnit='\xB5m'"), {0.2, 0.3, 2}, "um")
            .empty());
  CHECK(check(xml("6.ome.tif", ""), {1, 1, 1}, "").empty());
}

TEST_CASE("a size that is given comes first, and a printer's is none", "[tiff]") {
  const Folder folder;
  const auto sized = write_pages(folder / "j.tif", 2, image_j("images=2\nslices=2\nunit=mm\nspacing=3\n"), 4);
  RawDescription raw;
  raw.spacing = glm::dvec3(0.25, 0.125, 3);
  CHECK(open_volume(sized, raw)->grid().spacing == *raw.spacing);
  for (const char* description : {"a photograph", "ImageJ=1.53t\nimages=2\n"})
    CHECK(open_volume(write_pages(folder / "p.tif", 2, description, 300))->grid().spacing == glm::dvec3(1));
}

TEST_CASE("pages of colours become their luminance or one of them", "[tiff]") {
  const Folder folder;
  for (const int samples : {3, 4}) {
    const auto path = write_pages(folder / "a.tif", {.count = 2, .samples = samples});
    const auto one = [&](const std::string& channel) {
      return letters_of(*open_volume(path, {}, {.channel = channel}));
    };
    CHECK(one("r") == "ab");
    CHECK(one("2") == "cd");
    CHECK(one("") == "bc");  // of a, b, c: 97 * 0.2126 + 98 * 0.7152 + 99 * 0.0722 = 97.86
    CHECK(open_volume(path)->notes().channels == samples);
    CHECK(says(message_of([&] { one("x"); }), "has no such channel"));
  }
  const auto two = write_pages(folder / "2.tif", {.count = 2, .samples = 2});
  CHECK(letters_of(*open_volume(two, {}, {.channel = "1"})) == "bc");
}

TEST_CASE("ImageJ's slices behind its only page are read", "[tiff]") {
  const Folder folder;
  const auto path = write_pages(folder / "a.tif", 1, image_j("images=6\nchannels=2\nslices=3\n"));
  // The page's pixels move to the end, where the other planes can follow.
  auto bytes = slurp(path);
  const auto begin = bytes.find(std::string(12, 'a'));
  REQUIRE(begin != std::string::npos);
  const auto offset = bytes_of(std::uint32_t(begin));
  const auto field = bytes.find(std::string("\x11\x01\x04\0\x01\0\0\0", 8) + offset);
  REQUIRE(field != std::string::npos);
  bytes.replace(field + 8, 4, bytes_of(std::uint32_t(bytes.size())));
  for (int p = 0; p < 6; ++p) bytes += std::string(12, char('p' + p));
  CHECK(letters_of(write(path, bytes), 0, "0") == "prt");
  CHECK(letters_of(path, 0, "1") == "qsu");
  write(path, bytes.substr(0, bytes.size() - 1));
  CHECK(says(message_of([&] { open_volume(path); }), "3 slices (by its ImageJ), and has 1 pages"));
  write_pages(path, {.count = 1, .description = image_j("images=6\nslices=6\n"), .compression = "lzw"});
  write(path, slurp(path) + std::string(100, 'x'));
  CHECK(says(message_of([&] { open_volume(path); }), "6 slices (by its ImageJ), and has 1 pages"));
}

TEST_CASE("a stack whose description is cut off is refused", "[tiff][bad]") {
  const Folder folder;
  const auto text = image_j("images=6\nchannels=2\nslices=3\n");
  const auto path = write_pages(folder / "a.tif", 6, text);
  // The text moves to the end, where it is the first to be lost. Without it the channels would be slices.
  auto bytes = slurp(path);
  const auto field = bytes.find(std::string("\x0E\x01\x02\0", 4) + bytes_of(std::uint32_t(text.size() + 1)));
  REQUIRE(field != std::string::npos);
  bytes.replace(field + 8, 4, bytes_of(std::uint32_t(bytes.size())));
  CHECK(letters_of(write(path, bytes + text + '\0'), 0, "1") == "bdf");
  write(path, bytes + text.substr(0, text.size() / 2));
  CHECK(says(message_of([&] { open_volume(path); }), not_there));
}

TEST_CASE("pages that lead beyond the end or in a loop, or lack strips, are refused", "[tiff][bad]") {
  const Folder folder;
  const auto path = write_pages(folder / "a.tif", 3, "plain");
  const auto bytes = slurp(path);
  std::vector<std::size_t> links{4};  // where the pages' places are written
  while (const auto page = number_at(bytes, links.back(), 4))
    links.push_back(page + 2 + 12 * number_at(bytes, page, 2));
  REQUIRE(links.size() == 4);
  const auto refused = [&](std::string damaged) {
    return says(message_of([&] { open_volume(write(path, damaged)); }), not_there);
  };
  const auto end = bytes_of(std::uint32_t(bytes.size()));
  CHECK(refused(bytes.substr(0, links[3]).replace(links[2], 4, end)));
  CHECK(refused(std::string(bytes).replace(links[3], 4, end)));
  CHECK(refused(std::string(bytes).replace(links[3], 4, bytes.substr(4, 4))));
  CHECK(refused(std::string(bytes).replace(links[3], 4, bytes.substr(links[2], 4))));
  // The second page ends with the file, all but the place of a third.
  const auto second = bytes.substr(number_at(bytes, links[1], 4), links[2] - number_at(bytes, links[1], 4));
  CHECK(refused(std::string(bytes).replace(links[1], 4, end) + second));
  CHECK(letters_of(*open_volume(write(
            path, std::string(bytes).replace(links[1], 4, end) + second + std::string(4, '\0')))) == "ab");
  // With strips of one row there are three of them.
  const auto rows = bytes.find("\x16\x01", number_at(bytes, 4, 4));
  REQUIRE(rows != std::string::npos);
  CHECK(refused(std::string(bytes).replace(rows + 8, 1, "\x01")));
}

TEST_CASE("ImageJ's channels have the colours and ranges of its blocks, which must be there", "[tiff][bad]") {
  const Folder folder;
  const auto path = write_pages(folder / "a.tif", 2, image_j("images=2\nchannels=2\n"));
  const auto bytes = slurp(path);
  const std::string header = "JIJIgnar" + bytes_of(1) + "stul" + bytes_of(2);
  const std::string ranges = bytes_of(3.0) + bytes_of(200.5) + bytes_of(0.0) + bytes_of(65535.0);
  const std::string red = std::string(256, '\xFF') + std::string(512, '\0');
  const std::string blocks = header + ranges + red + std::string(768, '\xFF');
  // The first page's directory moves to the end and has two more fields.
  const auto with_blocks = [&](int bytes_of_last) {
    const std::size_t page = number_at(bytes, 4, 4), fields = number_at(bytes, page, 2);
    std::string all = bytes + bytes_of(int(header.size())) + bytes_of(int(ranges.size())) + bytes_of(768) +
                      bytes_of(bytes_of_last) + blocks;
    const auto field = [](int tag, int type, std::size_t count, std::size_t value) {
      return bytes_of(std::uint16_t(tag)) + bytes_of(std::uint16_t(type)) + bytes_of(std::uint32_t(count)) +
             bytes_of(std::uint32_t(value));
    };
    all.replace(4, 4, bytes_of(std::uint32_t(all.size())));
    return all + bytes_of(std::uint16_t(fields + 2)) + bytes.substr(page + 2, 12 * fields) +
           field(50838, 4, 4, bytes.size()) + field(50839, 1, blocks.size(), bytes.size() + 16) +
           bytes.substr(page + 2 + 12 * fields, 4);
  };
  const auto channels = open_volume(write(path, with_blocks(768)))->notes().of_channels;
  REQUIRE(channels.size() == 2);
  CHECK(channels[0].colour == glm::dvec3(1, 0, 0));
  CHECK(channels[1].colour == glm::dvec3(1, 1, 1));
  CHECK(channels[0].window == glm::dvec2(3, 200.5));
  CHECK(!channels[1].window);
  CHECK(says(message_of([&] { open_volume(write(path, with_blocks(769))); }), not_there));
}

TEST_CASE("smaller copies of pages are no slices", "[tiff]") {
  const Folder folder;
  const auto path = write_pages(folder / "a.tif", 4, "pyramid");
  // The field NewSubfileType replaces one that no reader needs here.
  auto bytes = slurp(path);
  std::size_t at = 0;
  for (int page = 0; page < 4; ++page, ++at) {
    at = bytes.find(std::string("\x12\x01\x03\0\x01\0\0\0", 8), at);  // Orientation
    REQUIRE(at != std::string::npos);
    if (page % 2 == 1) bytes.replace(at, 12, std::string("\xFE\0\x04\0\x01\0\0\0\x01\0\0\0", 12));
  }
  CHECK(letters_of(*open_volume(write(path, bytes))) == "ac");
}

TEST_CASE("a folder of single slices by ImageJ is a stack", "[tiff]") {
  const Folder folder;
  for (int z = 0; z < 3; ++z) write_pages(folder / fmt::format("s{}.tif", z), 1, image_j(""));
  CHECK(open_volume(folder.path())->grid().dims.z == 3);
}

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <utility>

#include "formats/captured_log.hpp"
#include "formats/dicom_images.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace files;

namespace {

std::string written_by_oiio(const fs::path& path, const std::vector<std::uint8_t>& pixels, int width,
                            int height) {
  auto out = OIIO::ImageOutput::create(path.string());
  REQUIRE(out);
  OIIO::ImageSpec spec(width, height, 1, OIIO::TypeDesc::UINT8);
  spec.attribute("CompressionQuality", 100);
  REQUIRE(out->open(path.string(), spec));
  REQUIRE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  out->close();
  const auto bytes = slurp(path);
  // DICOM has JPEG 2000's codestream without the boxes around it.
  const auto codestream = bytes.find("\xFF\x4F\xFF\x51");
  return codestream == std::string::npos ? bytes : bytes.substr(codestream);
}

/// One image of a series: where it lies, elements that tell it apart, the byte its pixels are made of.
struct Placed {
  std::string position;
  std::string more = {};
  char value = 'a';
};

std::string at_height(double z) { return fmt::format("0\\0\\{}", z); }

fs::path write_images(const fs::path& folder, const std::vector<Placed>& images, Dicom image = {}) {
  fs::create_directories(folder);
  image.bits = 8;
  image.is_signed = false;
  for (const auto& [position, more, value] : images) {
    image.position = position;
    image.more = more;
    image.pixels = std::string(std::size_t(nx * ny), value);
    write(folder / fmt::format("{}.dcm", image.number), image.bytes());
    ++image.number;
  }
  return folder;
}

/// The byte of each slice.
std::string letters_of(VolumeSource& source) {
  std::string letters;
  for (int z = 0; z < source.grid().dims.z; ++z) letters += read_slice(source, z)[0];
  return letters;
}
std::string letters_of(const fs::path& path, const VolumeChoice& choice = {}) {
  return letters_of(*open_volume(path, {}, choice));
}

std::string complaint_of(const fs::path& path, const VolumeChoice& choice = {}) {
  return message_of([&] { open_volume(path, {}, choice); });
}

std::string time_index(std::uint32_t time) {
  return Dicom::sequence(0x20, 0x9111, {Dicom::element(0x20, 0x9128, "UL", bytes_of(time))});
}

/// A multi-frame image of which each frame has its position and other groups.
Dicom frames_at(const std::vector<Placed>& frames) {
  auto image = enhanced({});
  image.frames = int(frames.size());
  image.bits = 8;
  image.is_signed = false;
  image.pixels.clear();
  std::vector<std::string> items;
  for (const auto& [position, more, value] : frames) {
    image.pixels += std::string(std::size_t(nx * ny), value);
    items.push_back(plane_at(position) + more);
  }
  image.more = groups(0x9229, {shared_group("1")}) + groups(0x9230, items);
  return image;
}

}  // namespace

TEST_CASE("DICOM pixels are the same in every encoding", "[dicom]") {
  for (const char* syntax : {implicit, big_endian, deflated_syntax, rle, lossless}) {
    CAPTURE(syntax);
    const Folder folder;
    for (int z = 0; z < nz; ++z) {
      Dicom slice;
      slice.syntax = syntax;
      slice.number = z + 1;
      slice.position = fmt::format("-10\\-20\\{}", -30 + 3 * z);
      slice.pixels = slice_of_samples(z);
      if (slice.syntax == rle) slice.fragments = {"", rle_frame(slice.pixels)};
      if (slice.syntax == lossless) slice.fragments = {"", lossless_jpeg_frame(slice.pixels)};
      write(folder / fmt::format("{}.dcm", z), slice.bytes());
    }
    const auto source = open_volume(folder.path());
    CHECK(source->grid().type == ScalarType::int16);
    CHECK(source->grid().spacing == glm::dvec3(1, 2, 3));
    CHECK(source->grid().origin == glm::dvec3(-10, -20, -30));
    CHECK((read_all(*source) == samples<short>()));
  }
}

TEST_CASE("bytes are in the right order in big-endian DICOM, in words and alone", "[dicom]") {
  for (const char* vr : {"OB", "OW"}) {
    const Folder folder;
    Dicom image;
    image.syntax = big_endian;
    image.bits = 8;
    image.is_signed = false;
    image.columns = 3;
    image.rows = 1;
    image.pixels = "abc";
    auto bytes = image.bytes();
    if (std::string(vr) == "OW") {
      bytes.replace(bytes.rfind("OB"), 2, "OW");
      bytes.replace(bytes.size() - 4, 4, std::string("ba\0c", 4));
    }
    CHECK(read_all(*open_volume(write(folder / "a.dcm", bytes))) == "abc");
  }
}

TEST_CASE("multi-frame DICOM is a volume in every encoding", "[dicom]") {
  const auto check = [](const Dicom& image) {
    CAPTURE(image.syntax, image.fragments.size());
    const Folder folder;
    const auto source = open_volume(write(folder / "a.dcm", image.bytes()));
    CHECK(is_sample(*source));
  };
  check(all_frames());
  for (const char* syntax : {rle, lossless}) {
    auto image = all_frames();
    image.syntax = syntax;
    image.fragments = {""};
    std::vector<std::string> frames;
    for (int z = 0; z < nz; ++z) {
      const auto frame =
          image.syntax == rle ? rle_frame(slice_of_samples(z)) : lossless_jpeg_frame(slice_of_samples(z));
      frames.push_back(frame.size() % 2 == 0 ? frame : frame + '\0');
      image.fragments.push_back(frame);
    }
    check(image);
    // Each frame has two fragments; the offset table says which.
    image.fragments = {""};
    std::uint32_t offset = 0;
    for (const auto& frame : frames) {
      image.fragments[0] += bytes_of(offset);
      image.fragments.push_back(frame.substr(0, 20));
      image.fragments.push_back(frame.substr(20));
      offset += std::uint32_t(frame.size()) + 16;
    }
    check(image);
  }
}

TEST_CASE("an enhanced multi-frame image lies where its groups say", "[dicom]") {
  const Folder folder;
  const auto source =
      open_volume(write(folder / "a.dcm", enhanced({"7\\8\\9", "3\\8\\9", "-1\\8\\9"}).bytes()));
  const auto& grid = source->grid();
  CHECK(grid.origin == glm::dvec3(7, 8, 9));
  CHECK(grid.spacing == glm::dvec3(1, 2, 4));
  CHECK(grid.direction[0] == glm::dvec3(0, 1, 0));
  CHECK(grid.direction[1] == glm::dvec3(0, 0, -1));
  CHECK(grid.direction[2] == glm::dvec3(-1, 0, 0));
  std::string expected;
  visit_type(grid.type, [&](auto zero) {
    using T = decltype(zero);
    for (int i = 0; i < nx * ny * nz; ++i) expected += bytes_of(T(2 * sample<short>(i, 0, 0) + 5));
  });
  CHECK((read_all(*source) == expected));
}

TEST_CASE("frames whose distance is negative lie where they say", "[dicom]") {
  const auto distance = Dicom::element(0x18, 0x88, "DS", "-10");
  const Folder folder;
  for (const bool in_group : {false, true}) {
    CAPTURE(in_group);
    auto image = frames_at({{"0\\0\\30", "", 'a'}, {"0\\0\\20", "", 'b'}, {"0\\0\\10", "", 'c'}});
    const std::string shared =
        Dicom::sequence(0x20, 0x9116, {Dicom::element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")}) +
        Dicom::sequence(0x28, 0x9110,
                        {(in_group ? distance : "") + Dicom::element(0x28, 0x30, "DS", "2\\1")});
    std::vector<std::string> places;
    for (const char* position : {"0\\0\\30", "0\\0\\20", "0\\0\\10"}) places.push_back(plane_at(position));
    image.more = (in_group ? "" : distance) + groups(0x9229, {shared}) + groups(0x9230, places);
    const auto source = open_volume(write(folder / "a.dcm", image.bytes()));
    CHECK(source->grid().spacing == glm::dvec3(1, 2, 10));
    CHECK(source->grid().origin == glm::dvec3(0, 0, 10));
    CHECK(letters_of(*source) == "cba");
  }
  // Nuclear medicine has one position, and a distance against the normal.
  Dicom stack = all_frames();
  stack.storage_class = "1.2.840.10008.5.1.4.1.1.20";
  stack.position = "0\\0\\30";
  stack.more = distance;
  const auto source = open_volume(write(folder / "b.dcm", stack.bytes()));
  CHECK(source->grid().spacing == glm::dvec3(1, 2, 10));
  CHECK(source->grid().direction[2] == glm::dvec3(0, 0, -1));
}

TEST_CASE("lossy DICOM is read with the codec's own error", "[dicom]") {
  constexpr int width = 64, height = 64;
  std::vector<std::uint8_t> pixels(width * height);
  for (int i = 0; i < width * height; ++i)
    pixels[std::size_t(i)] = std::uint8_t(20 + 2 * (i % width) + i / width);
  const std::pair<const char*, const char*> codecs[] = {{"1.2.840.10008.1.2.4.50", "a.jpg"},
                                                        {"1.2.840.10008.1.2.4.91", "a.j2k"}};
  for (const auto& [syntax, name] : codecs) {
    CAPTURE(syntax);
    const Folder folder;
    Dicom image;
    image.syntax = syntax;
    image.columns = width;
    image.rows = height;
    image.bits = 8;
    image.is_signed = false;
    image.fragments = {"", written_by_oiio(folder / name, pixels, width, height)};
    const auto read = read_all(*open_volume(write(folder / "a.dcm", image.bytes())));
    REQUIRE(read.size() == pixels.size());
    if (std::string(name) == "a.jpg") {
      std::string& frame = image.fragments[1];
      frame.insert(frame.rfind("\xFF\xD9"), "what libjpeg warns of");
      const Folder other;
      const auto odd = write(other / "a.dcm", image.bytes());
      const CapturedLog log;
      CHECK(read_all(*open_volume(odd)) == read);
      CHECK(says(log.text(), "ringsplat: warning: " + odd.string() + ": Corrupt JPEG data"));
      CHECK_FALSE(says(log.text(), "\nCorrupt"));
    }
    int worst = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i)
      worst = std::max(worst, std::abs(int(static_cast<unsigned char>(read[i])) - int(pixels[i])));
    CHECK(worst <= 6);
  }
}

TEST_CASE("lossless JPEG of any depth is read, whatever else is in it", "[dicom]") {
  for (const int depth : {9, 10, 12, 14, 16}) {
    CAPTURE(depth);
    Dicom image;
    image.syntax = lossless;
    image.stored = depth;
    image.is_signed = false;
    std::vector<std::uint16_t> pixels;
    std::string expected;
    for (int i = 0; i < nx * ny; ++i) pixels.push_back(std::uint16_t(i * 997 % (1 << depth)));
    for (const auto pixel : pixels) expected += bytes_of(pixel);
    const auto frame = lossless_jpeg_frame(pixels, nx, ny, depth);
    // A JFIF revision that does not exist, a comment, and fill bytes.
    const std::string more =
        "\xFF\xE0" + big16(16) + "JFIF" + std::string(10, '\0') + "\xFF\xFE" + big16(4) + "hi" + "\xFF";
    image.fragments = {"", frame.substr(0, 2) + more + frame.substr(2) + "after the end"};
    const Folder folder;
    CHECK((read_all(*open_volume(write(folder / "a.dcm", image.bytes()))) == expected));
  }
}

TEST_CASE("DICOM values are rescaled backwards, and beyond 32 bits", "[dicom]") {
  const Folder folder;
  Dicom image;
  image.pixels = slice_of_samples(0);
  image.slope = "-1";
  const auto negative = open_volume(write(folder / "negative.dcm", image.bytes()));
  REQUIRE(negative->grid().type == ScalarType::int32);
  image.slope = "900000";
  const auto large = open_volume(write(folder / "large.dcm", image.bytes()));
  REQUIRE(large->grid().type == ScalarType::float64);
  const auto stored = slice_of_samples(0), turned = read_all(*negative), scaled = read_all(*large);
  for (int i = 0; i < nx * ny; ++i) {
    const int value = reinterpret_cast<const short*>(stored.data())[i];
    CHECK(reinterpret_cast<const std::int32_t*>(turned.data())[i] == -value);
    CHECK(reinterpret_cast<const double*>(scaled.data())[i] == 900000.0 * value);
  }
}

TEST_CASE("DICOM bytes of which few bits count are read", "[dicom]") {
  for (const bool compressed : {false, true}) {
    CAPTURE(compressed);
    Dicom image;
    image.bits = 8;
    image.stored = 7;
    image.is_signed = false;
    std::vector<std::uint16_t> values;
    for (int i = 0; i < nx * ny; ++i) values.push_back(std::uint16_t(6 * i));
    for (const auto value : values) image.pixels += char(value);
    if (compressed) image.syntax = lossless;
    if (compressed) image.fragments = {"", lossless_jpeg_frame(values, nx, ny, 8)};
    const Folder folder;
    CHECK((read_all(*open_volume(write(folder / "a.dcm", image.bytes()))) == image.pixels));
    image.photometric = "MONOCHROME1";
    const auto inverted = write(folder / "a.dcm", image.bytes());
    CHECK(says(message_of([&] { open_volume(inverted); }), "MONOCHROME1 of 7 bits stored in 8"));
  }
}

TEST_CASE("DICOM pixels of few bits are rescaled to what holds them", "[dicom]") {
  for (const char* rescale : {"1\\0", "2\\0", "1\\-1000", "1\\3000", "0.5\\1"})
    for (const int stored : {7, 8, 12, 16})
      for (const bool is_signed : {false, true}) {
        CAPTURE(rescale, stored, is_signed);
        const std::string both = rescale;
        Dicom image;
        image.stored = stored;
        image.is_signed = is_signed;
        image.slope = both.substr(0, both.find('\\'));
        image.intercept = both.substr(both.find('\\') + 1);
        const int lowest = is_signed ? -50 : 0;
        for (int i = 0; i < nx * ny; ++i) image.pixels += bytes_of(std::uint16_t(lowest + 5 * i));
        const Folder folder;
        const auto source = open_volume(write(folder / "a.dcm", image.bytes()));
        const auto bytes = read_all(*source);
        visit_type(source->grid().type, [&](auto zero) {
          using T = decltype(zero);
          std::string expected;
          for (int i = 0; i < nx * ny; ++i)
            expected += bytes_of(T((lowest + 5 * i) * std::stod(image.slope) + std::stod(image.intercept)));
          CHECK((bytes == expected));
        });
      }
}

TEST_CASE("unreadable DICOM files beside a good series are named and left out", "[dicom]") {
  for (const bool whole_folder : {true, false}) {
    const Folder folder;
    write_dicom_series(folder.path());
    Dicom bad;
    bad.number = 9;
    bad.pixels = slice_of_samples(0);
    write(folder / "broken.dcm", bad.bytes().substr(0, 500));
    write(folder / "lost.dcm", "not DICOM");
    write(folder / "notes.txt", "not DICOM and no matter");
    const auto path = whole_folder ? folder.path() : folder / "image1.dcm";
    const CapturedLog log;
    CHECK((read_all(*open_volume(path)) == samples<short>()));
    CHECK_NOTHROW(open_volume(path));  // warns only once
    const auto said = log.text();
    CAPTURE(said);
    CHECK(
        says(said, "left out: " + (folder / "broken.dcm").string() + " is cut short or damaged at byte 500"));
    CHECK(says(said, "left out: " + (folder / "lost.dcm").string() + " is no DICOM file"));
    CHECK(std::count(said.begin(), said.end(), '\n') == 2);
    CHECK(says(message_of([&] { open_volume(folder / "broken.dcm"); }), "cut short or damaged"));
  }
}

TEST_CASE("many unreadable DICOM files are counted, not listed", "[dicom]") {
  const Folder folder;
  write_dicom_series(folder.path());
  for (int i = 0; i < 20; ++i) write(folder / fmt::format("x{}.dcm", i), "not DICOM");
  const CapturedLog log;
  open_volume(folder.path());
  CHECK(says(log.text(), "left out: 15 more files"));
}

TEST_CASE("a DICOM file without an ending is taken by its name, with its series", "[dicom]") {
  const Folder folder;
  Dicom other;
  other.series = "1.2.3.4.6";
  for (int z = 0; z < 2; ++z) {
    other.number = z + 1;
    other.position = fmt::format("0\\0\\{}", z);
    other.pixels = slice_of_samples(z);
    write(folder / fmt::format("IM{:06}", z), other.bytes());
  }
  write_dicom_series(folder.path());
  CHECK(open_volume(folder / "IM000001")->grid().dims.z == 2);
  CHECK(open_volume(folder / "image1.dcm")->grid().dims.z == nz);
  RawDescription raw;
  raw.type = ScalarType::int16;
  CHECK(says(message_of([&] { open_volume(folder / "IM000001", raw); }), "describes itself"));
}

TEST_CASE("series in folders below are found, listed and chosen", "[dicom]") {
  const Folder folder;
  Dicom scout, lung;
  scout.series = "1.2.3.100.7";
  scout.more = lung.more = "";
  write_images(folder / "A",
               {{at_height(0),
                 Dicom::element(0x8, 0x103E, "LO", "Scout") + Dicom::element(0x20, 0x11, "IS", "1"), 's'}},
               scout);
  lung.series = "1.2.3.200.8";
  const auto named = Dicom::element(0x8, 0x103E, "LO", "Lung 1.0") + Dicom::element(0x20, 0x11, "IS", "2");
  write_images(folder / "B" / "C", {{at_height(0), named, 'l'}, {at_height(1), named, 'm'}}, lung);
  fs::create_directory_symlink(folder.path(), folder / "B" / "loop");
  fs::create_symlink("nowhere", folder / "B" / "broken");
  {
    const CapturedLog log;
    const auto source = open_volume(folder.path());
    CHECK(letters_of(*source) == "lm");
    CHECK(source->notes().series ==
          std::vector<std::string>{"1 slice CT, series 1, 'Scout', UID ...2.3.100.7",
                                   "2 slices CT, series 2, 'Lung 1.0', UID ...2.3.200.8"});
    CHECK(says(log.text(),
               "holds 2 DICOM series, taken is the longest (2 slices); --series takes another: 1 "
               "slice CT, series 1, 'Scout', UID ...2.3.100.7; 2 slices"));
  }
  for (const char* name : {"1", "scout", "1.2.3.100.7", "1.2.3.1", "100.7"}) {
    CAPTURE(name);
    CHECK(letters_of(folder.path(), {.series = name}) == "s");
  }
  CHECK(letters_of(folder.path(), {.series = "lung 1.0"}) == "lm");
  CHECK(says(complaint_of(folder.path(), {.series = "1.2.3"}), "has 2 such series; hint: give"));
  CHECK(says(complaint_of(folder.path(), {.series = "liver"}), "has no such series; hint: give"));
  CHECK(letters_of(folder / "A", {.series = "1"}) == "s");
}

TEST_CASE("copies of a DICOM image count once", "[dicom]") {
  const Folder folder;
  write_images(folder / "a", {{at_height(0), "", 'a'}, {at_height(1), "", 'b'}});
  fs::copy(folder / "a", folder / "b");
  const CapturedLog log;
  CHECK(letters_of(folder.path()) == "ab");
  CHECK(says(log.text(), "2 files are copies of others and left out"));
}

TEST_CASE("time points of a DICOM series are told apart, not stacked", "[dicom]") {
  const auto is = [](unsigned group, unsigned id, const char* vr) {
    return [=](const std::string& value) { return Dicom::element(group, id, vr, value); };
  };
  const std::pair<const char*, std::function<std::string(const std::string&)>> kinds[] = {
      {"temporal position", is(0x20, 0x100, "IS")},
      {"trigger time", is(0x18, 0x1060, "DS")},
      {"acquisition number", is(0x20, 0x12, "IS")},
      {"acquisition time", is(0x8, 0x32, "TM")},
      {"echo time", is(0x18, 0x81, "DS")},
      {"b-value", [](const std::string& value) {
         return Dicom::element(0x18, 0x9087, "FD", bytes_of(std::stod(value)));
       }}};
  for (const auto& [what, element] : kinds) {
    CAPTURE(what);
    const Folder folder;
    write_images(folder.path(), {{at_height(3), element("20"), 'f'},
                                 {at_height(0), element("20"), 'd'},
                                 {at_height(3), element("9"), 'c'},
                                 {at_height(0), element("9"), 'a'}});
    const CapturedLog log;
    const auto source = open_volume(folder.path());
    CHECK(source->notes().frames == 2);
    CHECK(source->grid().spacing.z == 3);
    CHECK(letters_of(*source) == "ac");
    CHECK(says(log.text(), "time point 1 of 2 is shown; --frame N takes another, 0 to 1"));
    CHECK(letters_of(folder.path(), {.frame = 1}) == "df");
    CHECK(says(complaint_of(folder.path(), {.frame = 2}), "holds 2 time points; hint: frames are numbered"));
  }
}

TEST_CASE("time points that lack slices are refused", "[dicom]") {
  const Folder folder;
  write_images(folder.path(),
               {{at_height(0)}, {at_height(1)}, {at_height(2)}, {at_height(0)}, {at_height(1)}});
  CHECK(says(complaint_of(folder.path()),
             "3 places have 1 to 2 images each, so they are no whole time points"));
}

TEST_CASE("a missing DICOM slice is filled in at its place", "[dicom]") {
  const Folder folder;
  write_images(folder.path(), {{at_height(0), "", 'a'},
                               {at_height(2), "", 'c'},
                               {at_height(4), "", 'e'},
                               {at_height(10), "", 'n'},
                               {at_height(12), "", 'q'}});
  const CapturedLog log;
  const auto source = open_volume(folder.path());
  CHECK(source->grid().spacing.z == 2);
  CHECK(letters_of(*source) == "acehknq");
  CHECK(says(log.text(),
             "2 slices are missing and filled in from their neighbours: 2 between 3.dcm and 4.dcm"));
}

TEST_CASE("slices at uneven distances are averaged, warned of or refused by how uneven they are", "[dicom]") {
  const auto open = [](double jitter) {
    const Folder folder;
    write_images(folder.path(), {{at_height(0)}, {at_height(5 + jitter)}, {at_height(10)}, {at_height(15)}});
    const CapturedLog log;
    const auto text = message_of([&] {
      const auto source = open_volume(folder.path());
      CHECK(source->grid().dims.z == 4);
      CHECK(source->grid().spacing.z == 5);
    });
    return text + log.text();
  };
  CHECK(open(0.04).empty());
  CHECK(says(open(0.2), "slices are off their even places by up to 0.2 mm, 4 % of their distance"));
  CHECK(says(open(0.5),
             "not one stack of evenly spaced slices: 4 of them are 4.5 to 5.5 mm apart, and up to 0.5 mm"));
  const Folder folder;
  write_images(folder.path(), {{at_height(0)}, {at_height(1)}, {at_height(9)}});
  CHECK(says(complaint_of(folder.path()), "3 of them are 1 to 8 mm apart"));
}

TEST_CASE("a tilted gantry's slices lie where they were taken", "[dicom]") {
  const Folder folder;
  write_images(folder.path(), {{"0\\0\\0"}, {"0\\3\\4"}, {"0\\6\\8"}});
  const auto grid = open_volume(folder.path())->grid();
  CHECK(grid.spacing.z == 5);
  CHECK(glm::length(grid.direction[2] - glm::dvec3(0, 0.6, 0.8)) < 1e-12);
  CHECK(grid.direction[1] == glm::dvec3(0, 1, 0));
}

TEST_CASE("slices of several orientations are refused", "[dicom]") {
  const Folder folder;
  write_images(folder.path(), {{at_height(0)}, {at_height(1)}});
  Dicom turned;
  turned.number = 3;
  turned.orientation = "0\\1\\0\\0\\0\\-1";
  write_images(folder.path(), {{at_height(2)}}, turned);
  CHECK(says(complaint_of(folder.path()), "3.dcm is turned against the slices before it"));
}

TEST_CASE("frames lie where their groups say, in whatever order", "[dicom]") {
  const Folder folder;
  const auto write_frames = [&](const std::vector<Placed>& frames) {
    return write(folder / "a.dcm", frames_at(frames).bytes());
  };
  // Slices ascend along -x, the rows' normal.
  const auto mixed =
      open_volume(write_frames({{"3\\8\\9", "", 'b'}, {"7\\8\\9", "", 'a'}, {"-1\\8\\9", "", 'c'}}));
  CHECK(letters_of(*mixed) == "fgh");  // rescaled by 5
  CHECK(mixed->grid().origin == glm::dvec3(7, 8, 9));
  CHECK(mixed->grid().spacing == glm::dvec3(1, 2, 4));
  CHECK(mixed->grid().direction[2] == glm::dvec3(-1, 0, 0));
  const std::vector<Placed> times{{"0\\0\\0", time_index(2), 'x'},
                                  {"-1\\0\\0", time_index(2), 'y'},
                                  {"0\\0\\0", time_index(1), 'a'},
                                  {"-1\\0\\0", time_index(1), 'b'}};
  const auto first = open_volume(write_frames(times));
  CHECK(first->notes().frames == 2);
  CHECK(letters_of(*first) == "fg");
  CHECK(letters_of(folder / "a.dcm", {.frame = 1}) == "}~");
}

TEST_CASE("a DICOM volume says what took it and what its values are", "[dicom]") {
  const Folder folder;
  const auto notes = [&](const char* modality, const std::string& type) {
    Dicom image;
    image.pixels = slice_of_samples(0);
    if (!type.empty()) image.more = Dicom::element(0x28, 0x1054, "LO", type);
    auto bytes = image.bytes();
    const auto at = bytes.find(std::string("CS\2\0CT", 6));
    REQUIRE(at != std::string::npos);
    bytes.replace(at + 4, 2, modality);
    return open_volume(write(folder / "a.dcm", bytes))->notes();
  };
  CHECK(notes("CT", "").modality == "CT");
  CHECK(notes("CT", "").quantity == "HU");
  CHECK(notes("CT", "HU").quantity == "HU");
  CHECK(notes("CT", "OD").quantity.empty());
  CHECK(notes("mr", "").modality == "MR");
  CHECK(notes("MR", "").quantity.empty());
}

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "volume/captured_log.hpp"
#include "volume/dicom_images.hpp"

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
    CHECK(source->grid().dims == glm::ivec3(nx, ny, nz));
    CHECK((read_all(*source) == samples<short>()));
    for (const int z : {2, 0, 1}) CHECK((read_slice(*source, z) == slice_of_samples(z)));
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

#include "formats/dicom_images.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace files;

namespace {

std::string complaint_about(const std::string& bytes) {
  const Folder folder;
  const auto path = write(folder / "a.dcm", bytes);
  return message_of([&] { read_all(*open_volume(path)); });
}

template <class Change>
void check_refused(const char* message, Dicom image, Change&& change) {
  change(image);
  const auto text = complaint_about(image.bytes());
  CAPTURE(message, text);
  CHECK(says(text, message));
  CHECK(says(text, "a.dcm"));
  CHECK(says(text, "hint: "));
}

}  // namespace

TEST_CASE("DICOM pixels that are not what the header says are refused", "[dicom][bad]") {
  Dicom raw;
  raw.pixels = slice_of_samples(0);
  const auto refused = [&](const char* message, auto change) { check_refused(message, raw, change); };
  refused("promises 80000000000 bytes", [](Dicom& d) { d.frames = 2'000'000'000; });
  refused("Number of Frames (0028,0008) is -3", [](Dicom& d) { d.frames = -3; });
  refused("promises 80 bytes", [](Dicom& d) { d.frames = 2; });
  refused("12 bits allocated", [](Dicom& d) { d.bits = 12; });
  refused("Bits Stored (0028,0101) is 17", [](Dicom& d) { d.stored = 17; });
  refused("High Bit (0028,0102) is 16", [](Dicom& d) { d.high_bit = 16; });
  refused("High Bit (0028,0102) is 5", [](Dicom& d) { d.high_bit = 5; });
  refused("'PALETTE COLOR'", [](Dicom& d) { d.photometric = "PALETTE COLOR"; });
  refused("encoded as '1.2.840.10008.1.2.4.100'", [](Dicom& d) {
    d.syntax = "1.2.840.10008.1.2.4.100";
    d.fragments = {"", "video"};
  });
  refused("not in fragments", [](Dicom& d) { d.syntax = rle; });
  refused("are in fragments", [](Dicom& d) { d.fragments = {"", d.pixels}; });
  refused("have no fragments", [](Dicom& d) {
    d.syntax = rle;
    d.fragments = {""};
  });
  refused("32 bits per pixel", [](Dicom& d) {
    d.syntax = big_endian;
    d.bits = 32;
    d.pixels += d.pixels;
  });
  refused("floating-point", [](Dicom& d) { d.more = Dicom::element(0x7FE0, 8, "OF", d.pixels); });
  refused("is there twice",
          [](Dicom& d) { d.more = Dicom::element(0x28, 0x10, "US", bytes_of(std::uint16_t(ny))); });
}

TEST_CASE("DICOM geometry and rescaling that mean nothing are refused", "[dicom][bad]") {
  Dicom raw;
  raw.pixels = slice_of_samples(0);
  const auto refused = [&](const char* message, auto change) { check_refused(message, raw, change); };
  refused("Image Position (Patient) (0020,0032) has 2 numbers", [](Dicom& d) { d.position = "1\\2"; });
  refused("Image Position (Patient) (0020,0032) is 'here'", [](Dicom& d) { d.position = "here"; });
  refused("Image Position (Patient) (0020,0032) is '0\\0\\1e999'",
          [](Dicom& d) { d.position = "0\\0\\1e999"; });
  refused("not of two directions at a right angle", [](Dicom& d) { d.orientation = "1\\0\\0\\1\\0\\0"; });
  refused("not of two directions at a right angle", [](Dicom& d) { d.orientation = "0\\0\\0\\0\\0\\0"; });
  refused("Pixel Spacing (0028,0030) has the value 0", [](Dicom& d) { d.spacing = "0\\1"; });
  refused("Pixel Spacing (0028,0030) has 1 numbers", [](Dicom& d) { d.spacing = "1"; });
  refused("rescaled by 0 and 0", [](Dicom& d) { d.slope = "0"; });
  refused("rescaled by 1 and 1e+30", [](Dicom& d) { d.intercept = "1e30"; });
  refused("Grid Frame Offset Vector (3004,000C) has 2 numbers for 1 frames",
          [](Dicom& d) { d.more = Dicom::element(0x3004, 0xC, "DS", "0\\1"); });
}

TEST_CASE("enhanced multi-frame images that are no single stack are refused", "[dicom][bad]") {
  const auto refused = [](const char* message, const Dicom& image) {
    check_refused(message, image, [](Dicom&) {});
  };
  refused("not one stack of evenly spaced slices", enhanced({"0\\0\\0", "-1\\0\\0", "-5\\0\\0"}));
  auto image = enhanced({"0\\0\\0", "-1\\0\\0", "-2\\0\\0"});
  image.more = groups(0x9229, {Dicom::sequence(0x28, 0x9110, {Dicom::element(0x28, 0x30, "DS", "2\\1")})});
  refused("a pixel spacing and no orientation", image);
  image.more =
      groups(0x9230, {plane_at("0\\0\\0") + shared_group("1"), plane_at("-1\\0\\0") + shared_group("2"),
                      plane_at("-2\\0\\0") + shared_group("3")});
  refused("different rescaling", image);
}

TEST_CASE("compressed DICOM frames that contradict the header or are damaged are refused", "[dicom][bad]") {
  Dicom jpeg;
  jpeg.syntax = lossless;
  const auto frame = lossless_jpeg_frame(slice_of_samples(0));
  const auto refused = [&](const char* message, const std::string& changed) {
    check_refused(message, jpeg, [&](Dicom& d) { d.fragments = {"", changed}; });
  };
  const auto patched = [&](std::size_t at, const std::string& bytes) {
    auto changed = frame;
    return changed.replace(at, bytes.size(), bytes);
  };
  // FFD8, then the frame header: marker, length, precision, height, width, components.
  refused("cannot be decoded", patched(7, "\xFF\xFF\xFF\xFF"));
  refused("5 x 4 x 1 pixels of 16 bits for 5 x 3 x 1 of 16", patched(7, big16(3)));
  refused("of 16 bits for 5 x 4 x 1 of 8", patched(6, "\x08"));
  refused("of 16 bits for 5 x 4 x 1 of 12", patched(6, "\x0C"));
  refused("cannot be decoded", patched(11, "\x03"));
  refused("cannot be decoded", patched(3, "\xC0"));
  refused("cannot be decoded", "\xFF\xD9" + frame.substr(2));
  refused("cut short or damaged", "not a JPEG at all");
  refused("cannot be decoded", frame.substr(0, 15) + frame.substr(2));
  refused("cannot be decoded", frame.substr(0, 2) + frame.substr(15));
  refused("GDCM crashes on it", frame.substr(0, 15) + "\xFF\x01" + frame.substr(17));
  refused("is cut short", frame.substr(0, frame.size() - 2));
  refused("is cut short", frame.substr(0, 40));
  Dicom runs;
  runs.syntax = rle;
  const auto packed = rle_frame(slice_of_samples(0));
  check_refused("cannot be decoded", runs, [&](Dicom& d) { d.fragments = {"", packed.substr(0, 10)}; });
  check_refused("not of 2 segments", runs, [&](Dicom& d) { d.fragments = {"", '\1' + packed.substr(1)}; });
  check_refused("cannot be decoded", runs, [&](Dicom& d) {
    d.fragments = {"", packed.substr(0, packed.size() - 4)};
  });
  check_refused("cannot be decoded", runs, [&](Dicom& d) {
    d.fragments = {"", packed.substr(0, 8) + bytes_of(std::uint32_t(0xFFFFFF00)) + packed.substr(12)};
  });
  check_refused("cannot hold that many", runs, [&](Dicom& d) {
    d.rows = d.columns = 65535;
    d.fragments = {"", packed};
  });
  check_refused("3 fragments cannot be told to be 2 frames", runs, [&](Dicom& d) {
    d.frames = 2;
    d.fragments = {"", packed, packed, packed};
  });
}

TEST_CASE("damaged JPEG 2000 in DICOM is refused", "[dicom][bad]") {
  const auto size = [](int length, int width) {
    std::string s = "\xFF\x4F\xFF\x51" + big16(length) + big16(0);
    for (const int n : {width, ny, 0, 0, width, ny, 0, 0}) s += bytes_of(std::uint32_t(n), true);
    return s + big16(1) + "\x0F\1\1";
  };
  const std::string style = "\xFF\x52" + big16(12) + std::string("\0\0\0\1\0\0\4\4\0\1", 10);
  const auto tile = [](std::uint32_t length) {
    return "\xFF\x90" + big16(10) + big16(0) + bytes_of(length, true) + std::string("\0\1", 2);
  };
  const std::string data = "\xFF\x93";
  const std::string bad[] = {
      size(44, nx),
      size(41, 9),
      size(41, nx),
      size(41, nx) + "\xFF\x5C" + big16(40'000),
      size(41, nx) + "\xFF\x5C" + big16(1),
      size(41, nx) + "\xFF\x20" + style,
      size(41, nx) + tile(12),
      size(41, nx) + "\xFF\x52" + big16(5) + "abc" + tile(12),
      size(41, nx) + style + tile(1000),
      size(41, nx) + style + tile(3) + data,
      size(41, nx) + style + "\xFF\x90" + big16(8) + tile(14).substr(4) + data,
      size(41, nx) + style + tile(14),
      size(41, nx) + style + tile(14) + "\x8F\xAE",
      size(41, nx) + style + tile(0) + "\xFF\x58" + big16(60'000),
      size(41, nx) + style + tile(14) + data,
      size(41, nx) + style + tile(14) + data + std::string("\xFF\x52\0\0\0\0\0\0\0\0", 10),
  };
  for (const auto& frame : bad) {
    Dicom image;
    image.syntax = "1.2.840.10008.1.2.4.90";
    check_refused("", image, [&](Dicom& d) { d.fragments = {"", frame}; });
  }
}

TEST_CASE("what follows DICOM pixels is elements or zeros", "[dicom]") {
  Dicom image;
  image.pixels = slice_of_samples(0);
  const auto bytes = image.bytes();
  CHECK(complaint_about(bytes + Dicom::element(0xFFFC, 0xFFFC, "OB", "padding")).empty());
  CHECK(complaint_about(bytes + std::string(500, '\0')).empty());
  CHECK(says(complaint_about(bytes + "\xFF\xFF"), "cut short or damaged"));
  CHECK(says(complaint_about(bytes + std::string(20, '\xAB')), "cut short or damaged"));
}

TEST_CASE("deflated DICOM that is cut short is refused", "[dicom][bad]") {
  Dicom image;
  image.syntax = deflated_syntax;
  image.pixels = slice_of_samples(0);
  const auto bytes = image.bytes();
  for (const std::size_t cut : {8, 60, 200}) {
    const auto text = complaint_about(bytes.substr(0, bytes.size() - cut));
    CAPTURE(cut, text);
    CHECK(says(text, "a.dcm: the compressed data is cut short or damaged; hint: copy the file again"));
  }
}

TEST_CASE("DICOM sequences nested without end are refused", "[dicom][bad]") {
  Dicom image;
  image.pixels = slice_of_samples(0);
  const auto undefined = bytes_of(std::uint32_t(0xFFFFFFFF));
  for (int i = 0; i < 1000; ++i)
    image.more += bytes_of(std::uint16_t(0x29)) + bytes_of(std::uint16_t(0x10)) + "SQ" +
                  bytes_of(std::uint16_t(0)) + undefined + bytes_of(std::uint16_t(0xFFFE)) +
                  bytes_of(std::uint16_t(0xE000)) + undefined;
  CHECK(says(complaint_about(image.bytes()), "cut short or damaged"));
}

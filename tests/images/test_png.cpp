// PNG files by libpng, as builds without OpenImageIO read and write them; where there is OpenImageIO, with
// it.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <vector>

#include "images/image_file.hpp"
#include "images/image_library.hpp"
#include "support/catch.hpp"
#include "support/temporary_folder.hpp"

using namespace ringsplat;
using Catch::Matchers::Contains;
using support::TemporaryFolder;

namespace {

const ImageLibrary& png() { return image_library_of(RINGSPLAT_PNG_LIBRARY); }

/// The file that a library makes of an image.
std::string written(const ImageLibrary& library, const ImageData& image) {
  Bytes bytes;
  REQUIRE(library.write("a.png", image, "", bytes) == "");
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class T>
std::vector<T> ramp(int width, int height, int channels) {
  std::vector<T> samples(std::size_t(width * height * channels));
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k] = T(k * 2654435761U >> 7);
  return samples;
}

template <class T>
ImageData data_of(const std::vector<T>& samples, int width, int height, int channels) {
  return {width,
          height,
          channels,
          sizeof(T) == 1 ? SampleType::uint8 : SampleType::uint16,
          samples.data(),
          {{"ImageDescription", "{\"size\": 3}"},
           {"ringsplat:settings", "{\"size\": 4}"},
           {"oiio:ColorSpace", "sRGB"},
           {"oiio:UnassociatedAlpha", 1}}};
}

std::string stored(const TemporaryFolder& folder, const std::string& name, const std::string& bytes) {
  std::ofstream(folder / name, std::ios::binary) << bytes;
  return folder / name;
}

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += char(value >> shift & 255);
  return bytes;
}

/// A chunk of a PNG (PNG specification, "Chunk layout").
std::string chunk(const std::string& type, const std::string& data) {
  const std::string summed = type + data;
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(summed.data()), uInt(summed.size()));
  return big_endian(std::uint32_t(data.size())) + summed + big_endian(std::uint32_t(sum));
}

/// `form`: bits a sample and colour type; `more`: chunks before the pixels; `rows`: each with its filter's
/// byte.
std::string png_file(int width, int height, const std::string& form, const std::string& more,
                     const std::string& rows) {
  std::string packed(compressBound(rows.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
           rows.size());
  packed.resize(size);
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR", big_endian(std::uint32_t(width)) + big_endian(std::uint32_t(height)) + form +
                           std::string(3, '\0')) +
         more + chunk("IDAT", packed) + chunk("IEND", {});
}

/// What both libraries say of a file.
struct Read {
  int width, height, channels, alpha;
  SampleType type;
  std::string settings, description;
  int straight;
  std::vector<float> values;
  bool operator==(const Read&) const = default;
};

Read read(const ImageLibrary& library, const std::string& path) {
  const auto [file, problem] = library.open(path);
  INFO(path << ": " << problem);
  REQUIRE(file);
  const ImageShape shape = file->shape();
  Read all{shape.width,
           shape.height,
           shape.channels,
           shape.alpha_channel,
           shape.type,
           file->text("ringsplat:settings"),
           file->text("ImageDescription"),
           shape.alpha_channel >= 0 ? file->number("oiio:UnassociatedAlpha") : 0,
           std::vector<float>(std::size_t(shape.width * shape.height * shape.channels))};
  REQUIRE(file->read(0, shape.channels, SampleType::float32, all.values.data()) == "");
  CHECK(file->seek(0));
  CHECK_FALSE(file->seek(1));
  return all;
}

}  // namespace

TEST_CASE("a PNG by libpng gives back what was written, of 3 and 4 channels") {
  const TemporaryFolder folder;
  const int channels = GENERATE(3, 4);
  CAPTURE(channels);
  const auto bytes = ramp<std::uint8_t>(7, 5, channels);
  const std::string path = stored(folder, "a.png", written(png(), data_of(bytes, 7, 5, channels)));
  const auto [file, problem] = png().open(path);
  REQUIRE(file);
  std::vector<float> all(bytes.size()), first(7 * 5);
  REQUIRE(file->read(0, channels, SampleType::float32, all.data()) == "");
  for (std::size_t k = 0; k < all.size(); ++k) CHECK(all[k] == Approx(double(bytes[k]) / 255));
  CHECK(file->text("ringsplat:settings") == "{\"size\": 4}");
  CHECK(file->text("ImageDescription") == "{\"size\": 3}");
  REQUIRE(file->read(0, 1, SampleType::float32, first.data()) == "");
  for (std::size_t k = 0; k < first.size(); ++k) CHECK(first[k] == all[k * std::size_t(channels)]);
  CHECK(file->read(0, 1, SampleType::int32, first.data()) != "");
  CHECK(file->read(1, 1, SampleType::float32, first.data()) != "");
}

TEST_CASE("OpenImageIO and libpng read the same from each other's PNGs", "[openimageio]") {
  const TemporaryFolder folder;
  const int channels = GENERATE(1, 2, 3, 4);
  CAPTURE(channels);
  const auto bytes = ramp<std::uint8_t>(33, 9, channels);
  const auto words = ramp<std::uint16_t>(33, 9, channels);
  for (const ImageLibrary* writer : {&png(), &image_library()})
    for (const ImageData& image : {data_of(bytes, 33, 9, channels), data_of(words, 33, 9, channels)}) {
      if (writer == &png() && (channels < 3 || image.type != SampleType::uint8)) continue;
      const std::string path = stored(folder, "a.png", written(*writer, image));
      const Read by_png = read(png(), path), usual = read(image_library(), path);
      CHECK(by_png == usual);
    }
}

TEST_CASE("palettes, few bits and transparent colours are read by libpng as OpenImageIO does",
          "[openimageio]") {
  const TemporaryFolder folder;
  const std::string palette = chunk("PLTE", "\1\2\3\x40\x50\x60\x7f\x80\x90\xfd\xfe\xff"),
                    clear_colours = chunk("tRNS", "\x10\x80");
  const std::array files{
      png_file(4, 3, "\x04\3", palette, std::string("\0\x01\x23\0\x32\x10\0\x11\x22", 9)),
      png_file(4, 3, "\x04\3", palette + clear_colours, std::string("\0\x01\x23\0\x32\x10\0\x11\x22", 9)),
      png_file(4, 2, std::string("\1\0", 2), {}, std::string("\0\x50\0\xa0", 4)),
      png_file(4, 2, std::string("\2\0", 2), {}, std::string("\0\x1b\0\xe4", 4)),
      png_file(1, 2, "\x08\2", chunk("tRNS", std::string("\0\1\0\2\0\3", 6)),
               std::string("\0\1\2\3\0\1\2\4", 8))};
  for (const std::string& bytes : files) {
    const std::string path = stored(folder, "a.png", bytes);
    const Read by_png = read(png(), path), usual = read(image_library(), path);
    CHECK(by_png == usual);
  }
}

TEST_CASE("a PNG that is cut anywhere is an error of libpng") {
  const TemporaryFolder folder;
  const auto bytes = ramp<std::uint8_t>(16, 16, 4);
  const ImageData image = data_of(bytes, 16, 16, 4);
  const std::string whole = written(png(), image);
  for (std::size_t most = 0; most < whole.size(); most += 7) {
    const auto [file, problem] = png().open(stored(folder, "cut.png", whole.substr(0, most)));
    std::vector<float> values(bytes.size());
    const std::string failure = file ? file->read(0, 4, SampleType::float32, values.data()) : problem;
    CAPTURE(most);
    CHECK(failure != "");
  }
}

TEST_CASE("what libpng cannot do is said with the option that brings it") {
  const auto bytes = ramp<std::uint8_t>(2, 2, 3);
  Bytes file;
  CHECK_THAT(png().write("a.tif", data_of(bytes, 2, 2, 3), "", file),
             Contains("-DRINGSPLAT_WITH_OPENIMAGEIO=ON"));
  const TemporaryFolder folder;
  CHECK_THAT(png().open(stored(folder, "a.png", "II*\0 a TIFF")).problem,
             Contains("-DRINGSPLAT_WITH_OPENIMAGEIO=ON"));
  CHECK_FALSE(png().open(folder / "missing.png").file);
  Mask drawn;
  CHECK_THAT(png().draw_text("text", 12, "font.ttf", drawn), Contains("-DRINGSPLAT_WITH_OPENIMAGEIO=ON"));
}

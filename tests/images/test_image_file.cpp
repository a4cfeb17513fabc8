#include "images/image_file.hpp"

#include <OpenImageIO/color.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <thread>
#include <vector>

#include "base/output_file.hpp"
#include "base/srgb.hpp"
#include "images/image_library.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/file_size_limit.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

using namespace ringsplat;
using support::files_in;
using support::FileSizeLimit;
using support::TemporaryFolder;

namespace {

constexpr int width = 5, height = 3, channels = 4;

std::vector<float> ramp() {
  std::vector<float> samples(std::size_t(width * height * channels));
  std::iota(samples.begin(), samples.end(), 0.0F);
  for (float& sample : samples) sample /= 64.0F;
  return samples;
}

/// Attributes that make a second directory in a TIFF; no time, which would differ.
const std::vector<ImageData::Attribute> described{{"ImageDescription", "some text"},
                                                  {"oiio:ColorSpace", "sRGB"},
                                                  {"oiio:UnassociatedAlpha", 1},
                                                  {"DateTime", ""}};

void write_image_file(const std::filesystem::path& path, const ImageData& image) {
  OutputFile file(path);
  file.write(image_file_bytes(path.string(), image));
  file.commit();
}

std::string bytes_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("an image file gives back what was written") {
  const TemporaryFolder folder;
  const std::string path = folder / "a.exr";
  const std::vector<float> written = ramp();
  write_image_file(path, {width,
                          height,
                          channels,
                          SampleType::float32,
                          written.data(),
                          {{"ImageDescription", "a ramp"}, {"ringsplat:count", 7}}});

  const auto [file, problem] = open_image_file(path);
  REQUIRE(file);
  CHECK(problem.empty());
  const ImageShape shape = file->shape();
  CHECK(shape.width == width);
  CHECK(shape.height == height);
  CHECK(shape.depth == 1);
  CHECK(shape.channels == channels);
  CHECK(shape.alpha_channel == 3);
  CHECK(shape.type == SampleType::float32);
  CHECK(shape.type_name == "float");
  CHECK(shape.bytes == written.size() * sizeof(float));
  CHECK(file->text("ImageDescription") == "a ramp");
  CHECK(file->text("nothing") == "");
  CHECK(file->number("ringsplat:count") == 7);
  CHECK(file->number("nothing") == 0);

  std::vector<float> all(written.size());
  REQUIRE(file->read(0, channels, SampleType::float32, all.data()) == "");
  CHECK(all == written);
  std::vector<double> first(std::size_t(width * height));
  REQUIRE(file->read(0, 1, SampleType::float64, first.data()) == "");
  for (std::size_t pixel = 0; pixel < first.size(); ++pixel)
    CHECK(first[pixel] == double(written[channels * pixel]));

  CHECK(file->seek(0));
  CHECK_FALSE(file->seek(1));
}

TEST_CASE("threads may read and write pictures at once, and one of them loads the library", "[threads]") {
  const TemporaryFolder folder;
  const std::vector<float> written = ramp();
  std::array<std::string, 4> problems;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < problems.size(); ++t)
    threads.emplace_back([&, t] {
      try {
        const std::string path = folder / (std::to_string(t) + ".exr");
        write_image_file(path, {width, height, channels, SampleType::float32, written.data(), {}});
        const auto [file, problem] = open_image_file(path);
        std::vector<float> all(written.size());
        problems[t] = file ? file->read(0, channels, SampleType::float32, all.data()) : problem;
        if (all != written) problems[t] += " other values were read";
      } catch (const RunError& error) {
        problems[t] = error.what();
      }
    });
  for (auto& thread : threads) thread.join();
  for (const std::string& problem : problems) CHECK(problem == "");
}

TEST_CASE("what is no image is said, and what cannot be written is thrown") {
  const TemporaryFolder folder;
  std::ofstream(folder / "text.png") << "this is no picture";
  const auto [file, problem] = open_image_file(folder / "text.png");
  CHECK_FALSE(file);
  CHECK(problem != "");
  CHECK_FALSE(open_image_file(folder / "missing.png").file);

  const std::vector<float> samples = ramp();
  const ImageData image{width, height, channels, SampleType::float32, samples.data(), {}};
  CHECK_THROWS_AS(write_image_file(folder / "a.unknown", image), RunError);
  CHECK_THROWS_AS(write_image_file(folder / "no folder/a.exr", image), RunError);
  CHECK(files_in(folder.path()) == 1);
}

TEST_CASE("a picture's file has the bytes that its library writes by itself") {
  const std::string name = GENERATE("a.png", "a.tga", "a.jpg", "a.exr", "a.tif", "a.sgi");
  CAPTURE(name);
  const TemporaryFolder folder;
  constexpr int size = 200;
  const int depth = name == "a.jpg" ? 3 : 4;
  std::vector<std::uint8_t> samples(std::size_t(size * size * depth));
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k] = std::uint8_t(k * k >> 8);
  write_image_file(folder / name, {size, size, depth, SampleType::uint8, samples.data(), described});

  OIIO::ImageSpec spec(size, size, depth, OIIO::TypeDesc::UINT8);
  for (const auto& [key, value] : described)
    std::visit([&, &attribute = key](const auto& v) { spec.attribute(attribute, v); }, value);
  const auto output = OIIO::ImageOutput::create(name);
  REQUIRE(output->open(folder / ("by-itself-" + name), spec));
  REQUIRE(output->write_image(spec.format, samples.data()));
  REQUIRE(output->close());
  const bool same_bytes = bytes_of(folder / name) == bytes_of(folder / ("by-itself-" + name));
  CHECK(same_bytes);
}

TEST_CASE("a picture that finds no room for any one of its bytes is an error and leaves the old one alone") {
  const auto [name, most_channels, type] = GENERATE(table<std::string, int, SampleType>({
      {"a.png", 4, SampleType::uint8},
      {"a.tga", 4, SampleType::uint8},
      {"a.jpg", 3, SampleType::uint8},
      {"a.exr", 4, SampleType::float32},
      {"a.tif", 4, SampleType::uint8},
      {"a.sgi", 4, SampleType::uint8},  // its writer writes by name only
  }));
  CAPTURE(name);
  const TemporaryFolder folder;
  const std::vector<float> samples = ramp();
  const ImageData image{width, height, most_channels, type, samples.data(), described};
  write_image_file(folder / name, image);
  const auto bytes = std::filesystem::file_size(folder / name);
  REQUIRE(bytes > 40);
  std::ofstream(folder / name) << "the old picture";
  for (std::uintmax_t most = 0; most < bytes; ++most) {
    const FileSizeLimit limit(most);
    CAPTURE(most, bytes);
    const auto said = message_of<RunError>([&] { write_image_file(folder / name, image); });
    REQUIRE(said.find(folder / name) == 0);
    REQUIRE(said.find('\n') == std::string::npos);
  }
  CHECK(files_in(folder.path()) == 1);
  CHECK(bytes_of(folder / name) == "the old picture");
  // Files written by name go through memory, where the limit holds as well.
  const bool by_name = name == "a.tif" || name == "a.sgi";
  const FileSizeLimit limit(by_name ? bytes + (1 << 17) : bytes);
  write_image_file(folder / name, image);
  CHECK(std::filesystem::file_size(folder / name) == bytes);
}

TEST_CASE("a library that cannot be loaded is an error that names it and says what to do") {
  const auto what = message_of<RunError>([] { image_library_of("libringsplat_no_such.so"); });
  CHECK(says(what, "images can be neither read nor written: libringsplat_no_such.so"));
  CHECK(says(what, "LD_LIBRARY_PATH"));
  // An existing library, but the wrong one.
  CHECK_THROWS_AS(image_library_of("libm.so.6"), RunError);
}

TEST_CASE("display values and linear light are OpenImageIO's, to the bit") {
  constexpr int steps = 100'000;
  for (int k = 0; k <= steps; ++k) {
    const float value = float(k) / steps;
    REQUIRE(srgb_to_linear(value) == OIIO::sRGB_to_linear(value));
    REQUIRE(linear_to_srgb(value) == OIIO::linear_to_sRGB(value));
  }
}

TEST_CASE("texts of pictures that were written are not kept") {
  const auto write = [](int k) {
    const std::array<std::uint8_t, 4> pixel{1, 2, 3, 4};
    const std::string text = std::to_string(100'000 + k) + std::string(4000, 'x');
    const auto bytes =
        image_file_bytes("a.png", {1, 1, 4, SampleType::uint8, pixel.data(), {{"ImageDescription", text}}});
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find(text) !=
           std::string::npos;
  };
  const auto resident_pages = [] {
    std::size_t all = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return resident;
  };
  REQUIRE(write(0));
  const std::size_t before = resident_pages();
  bool same = true;
  for (int k = 1; k < 3000; ++k) same = write(k) && same;
  CHECK(same);
#ifndef __SANITIZE_ADDRESS__                // it keeps what was freed
  CHECK(resident_pages() < before + 1000);  // 4 MiB; it would be 12
#else
  CHECK(before > 0);
#endif
}

#include "ringsplat/images/image_file.hpp"

#include <algorithm>
#include <fstream>
#include <numeric>

#include "images/image_library.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/images/srgb.hpp"
#include "support/catch.hpp"
#include "support/temporary_folder.hpp"

using namespace ringsplat;
using support::TemporaryFolder;

namespace {

constexpr int width = 5, height = 3, channels = 4;

std::vector<float> ramp() {
  std::vector<float> samples(std::size_t(width * height * channels));
  std::iota(samples.begin(), samples.end(), 0.0F);
  for (float& sample : samples) sample /= 64.0F;
  return samples;
}

}  // namespace

TEST_CASE("an image file gives back what was written") {
  const TemporaryFolder folder;
  const std::string path = folder / "a.exr";
  const std::vector<float> written = ramp();
  REQUIRE(write_image_file(path, {width,
                                  height,
                                  channels,
                                  SampleType::float32,
                                  written.data(),
                                  {{"ImageDescription", "a ramp"}, {"ringsplat:count", 7}}}) == "");

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

TEST_CASE("what is no image, or cannot be written, is said and not thrown") {
  const TemporaryFolder folder;
  std::ofstream(folder / "text.png") << "this is no picture";
  const auto [file, problem] = open_image_file(folder / "text.png");
  CHECK_FALSE(file);
  CHECK(problem != "");
  CHECK_FALSE(open_image_file(folder / "missing.png").file);

  const std::vector<float> samples = ramp();
  const ImageData image{width, height, channels, SampleType::float32, samples.data(), {}};
  CHECK(write_image_file(folder / "a.unknown", image) != "");
  CHECK(write_image_file(folder / "no folder/a.exr", image) != "");
}

TEST_CASE("a library that cannot be loaded is an error that names it and says what to do") {
  try {
    image_library_of("libringsplat_no_such.so");
    FAIL("it was loaded");
  } catch (const RunError& error) {
    const std::string what = error.what();
    INFO(what);
    CHECK(what.find("images can be neither read nor written: libringsplat_no_such.so") == 0);
    CHECK(what.find("LD_LIBRARY_PATH") != std::string::npos);
  }
  // A library that is there but another one.
  CHECK_THROWS_AS(image_library_of("libm.so.6"), RunError);
}

TEST_CASE("display values and linear light are each other's inverse") {
  for (int byte = 0; byte < 256; ++byte) {
    const float value = float(byte) / 255.0F;
    CHECK(srgb_of_linear(linear_of_srgb(value)) == Approx(value).margin(1e-6));
  }
  CHECK(linear_of_srgb(0.5F) == Approx(0.2140411).epsilon(1e-5));
}

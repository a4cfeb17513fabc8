#include "images/image_io.hpp"

#include <chrono>
#include <cmath>
#include <thread>

#include "app/program_runner.hpp"
#include "images/image_file.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using app_test::TemporaryFolder;

namespace {

/// Premultiplied; alpha from 0 to 1 along x, straight grey from 0 to 1 along y.
Image ramp(int size) {
  Image image(size, size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const float alpha = float(x) / float(size - 1), grey = float(y) / float(size - 1);
      float* p = image.pixel(x, y);
      p[0] = grey * alpha;
      p[1] = 0.5F * grey * alpha;
      p[2] = 0;
      p[3] = alpha;
    }
  return image;
}

double srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

}  // namespace

TEST_CASE("EXR keeps every bit", "[mpi]") {
  const TemporaryFolder folder;
  Image image = ramp(37);
  image.pixel(3, 3)[0] = 17.25F;
  image.pixel(4, 4)[1] = -1e-30F;
  write_image(image, folder / "x.exr", {}, R"({"zoom": 2})");
  const StoredImage back = read_image(folder / "x.exr");
  CHECK(back.image == image);
  CHECK(back.linear);
  CHECK(back.settings == R"({"zoom": 2})");
}

TEST_CASE("EXR keeps depths in a channel Z, with alpha or over a background", "[mpi]") {
  const TemporaryFolder folder;
  Image image = ramp(9);
  image.depth.assign(81, INFINITY);
  image.depth[40] = -12.5F;
  for (const auto& background : {std::optional<glm::dvec3>(), std::optional(glm::dvec3(1.0))}) {
    write_image(image, folder / "x.exr", background, "");
    CHECK(open_image_file(folder / "x.exr").file->shape().depth_channel == (background ? 3 : 4));
    const StoredImage back = read_image(folder / "x.exr");
    CHECK((background ? back.image.depth == image.depth : back.image == image));
  }
}

TEST_CASE("8-bit pictures are straight sRGB, rounded to nearest", "[mpi]") {
  const TemporaryFolder folder;
  const Image image = ramp(64);
  for (const char* name : {"x.png", "x.tif", "x.tga"}) {
    INFO(name);
    write_image(image, folder / name, {}, "{}");
    const StoredImage back = read_image(folder / name);
    CHECK_FALSE(back.linear);
    CHECK(back.has_alpha);
    REQUIRE(back.image.width == 64);
    double worst = 0;
    for (int y = 0; y < 64; ++y)
      for (int x = 1; x < 64; ++x) {
        const double alpha = std::round(255 * double(image.pixel(x, y)[3])) / 255;
        const double grey = srgb(double(y) / 63);
        worst = std::max({worst, std::abs(back.image.pixel(x, y)[3] - alpha),
                          std::abs(back.image.pixel(x, y)[0] / alpha - grey)});
      }
    // Half a level, and the float's rounding.
    CHECK(worst < 0.5 / 255 + 1e-5);
  }
}

TEST_CASE("a background is put behind the picture in linear light", "[mpi]") {
  const TemporaryFolder folder;
  Image image(2, 1);
  // Half transparent black, and a fully transparent pixel.
  image.pixel(0, 0)[3] = 0.5F;
  for (const char* name : {"x.png", "x.jpg", "x.exr"}) {
    INFO(name);
    write_image(image, folder / name, glm::dvec3(1.0), "");
    const StoredImage back = read_image(folder / name);
    CHECK_FALSE(back.has_alpha);
    const double tolerance = std::string(name) == "x.jpg" ? 4.0 / 255 : 0.51 / 255;
    CHECK(back.image.pixel(0, 0)[1] == Approx(back.linear ? 0.5 : srgb(0.5)).margin(tolerance));
    CHECK(back.image.pixel(1, 0)[2] == Approx(1.0).margin(tolerance));
  }
}

TEST_CASE("display values come back to the linear light they were made from") {
  const TemporaryFolder folder;
  const Image image = ramp(64);
  write_image(image, folder / "x.png", {}, "");
  const StoredImage back = to_linear(read_image(folder / "x.png"));
  CHECK(back.linear);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 4; ++c)
        CHECK(back.image.pixel(x, y)[c] == Approx(image.pixel(x, y)[c]).margin(1.5 / 255));
}

TEST_CASE("settings are kept where the format can", "[mpi]") {
  const TemporaryFolder folder;
  for (const char* name : {"x.png", "x.tif", "x.exr", "x.jpg"}) {
    INFO(name);
    write_image(ramp(8), folder / name, glm::dvec3(0.0), R"({"azimuth": 30})");
    CHECK(read_image(folder / name).settings == R"({"azimuth": 30})");
  }
}

TEST_CASE("values that are no number become black, not noise") {
  const TemporaryFolder folder;
  Image image(1, 1);
  image.rgba = {NAN, INFINITY, -1, 1};
  write_image(image, folder / "x.png", {}, "");
  const StoredImage back = read_image(folder / "x.png");
  CHECK(back.image.rgba == Image::Floats{0, 1, 0, 1});
}

TEST_CASE("the same picture gives the same bytes at any time", "[mpi]") {
  const TemporaryFolder folder;
  const std::vector<std::string> endings{".png", ".exr", ".tif"};
  for (const auto& ending : endings) write_image(ramp(16), folder / ("a" + ending), {}, "{}");
  // File formats store times in seconds.
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  for (const auto& ending : endings) {
    write_image(ramp(16), folder / ("b" + ending), {}, "{}");
    INFO(ending);
    const bool same_bytes =
        app_test::read_text(folder / ("a" + ending)) == app_test::read_text(folder / ("b" + ending));
    CHECK(same_bytes);
  }
  CHECK(app_test::files_in(folder.path()) == 6);
}

TEST_CASE("pictures that cannot be written or read are refused") {
  const TemporaryFolder folder;
  CHECK_THROWS_AS(check_image_name("x.bmpp", "-o", false), InputError);
  CHECK_THROWS_AS(check_image_name("x", "-o", false), InputError);
  CHECK_THROWS_AS(check_image_name("x.jpg", "-o", true), InputError);
  CHECK_NOTHROW(check_image_name("x.PNG", "-o", true));
  CHECK_THROWS_AS(write_image(ramp(4), folder / "missing/x.png", {}, ""), RunError);
  CHECK_THROWS_AS(read_image(folder / "missing.png"), InputError);
  app_test::write_text(folder / "x.png", "not a picture");
  CHECK_THROWS_AS(read_image(folder / "x.png"), InputError);
}

TEST_CASE("A picture in memory has the bytes of its file", "[mpi]") {
  const TemporaryFolder folder;
  for (const std::string ending : {".png", ".exr"}) {
    write_image(ramp(9), folder / ("a" + ending), glm::dvec3(0.5), "{}");
    const Bytes bytes = image_bytes(ramp(9), ending, glm::dvec3(0.5), "{}");
    CHECK(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()) ==
          app_test::read_text(folder / ("a" + ending)));
  }
}

TEST_CASE("Display pixels are those of a written picture") {
  const TemporaryFolder folder;
  write_image(ramp(9), folder / "a.png", glm::dvec3(0.2), "");
  const Image stored = read_image(folder / "a.png").image;
  const auto rgb = display_bytes(ramp(9), glm::dvec3(0.2));
  REQUIRE(rgb.size() == 3 * 81);
  for (std::size_t p = 0; p < 81; ++p)
    for (std::size_t c = 0; c < 3; ++c)
      CHECK(std::lround(255 * stored.rgba[4 * p + c]) == long(rgb[3 * p + c]));
}

#include <bit>
#include <cmath>
#include <cstring>

#include "serve/picture_maker.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::serve;

namespace {

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

RenderedPicture grey(int side, float value, int level, std::uint64_t scene) {
  RenderedPicture picture;
  picture.image = Image(side, side);
  for (std::size_t k = 0; k < picture.image.rgba.size(); ++k)
    picture.image.rgba[k] = k % 4 == 3 ? 1.0F : value;
  picture.head.level = std::uint8_t(level);
  picture.head.levels = 3;
  picture.scene = scene;
  return picture;
}

}  // namespace

TEST_CASE("A picture's head has the bytes that the page reads") {
  const std::string message = picture_message({.kind = PictureKind::snapshot,
                                               .number = 0x01020304,
                                               .seq = 7,
                                               .width = 640,
                                               .height = 480,
                                               .level = 3,
                                               .levels = 6,
                                               .at_rest = true,
                                               .format = PictureFormat::png,
                                               .seconds = 0.25F,
                                               .pictures_a_second = 20,
                                               .time = 1234.5,
                                               .rmse = 2,
                                               .pictures = 2},
                                              "file");
  REQUIRE(std::endian::native == std::endian::little);
  CHECK(message.substr(0, 4) == "RSP1");
  CHECK(at<std::uint32_t>(message, 4) == 1);
  CHECK(message.substr(8, 4) == std::string("\x04\x03\x02\x01"));
  CHECK(at<std::uint32_t>(message, 12) == 7);
  CHECK(at<std::uint16_t>(message, 16) == 640);
  CHECK(at<std::uint16_t>(message, 18) == 480);
  CHECK(message.substr(20, 4) == std::string("\3\6\1\1"));
  CHECK(at<float>(message, 24) == 0.25F);
  CHECK(at<float>(message, 28) == 20);
  CHECK(at<double>(message, 32) == 1234.5);
  CHECK(at<float>(message, 40) == 2);
  CHECK(message.substr(44) == std::string("\2\0\0\0file", 8));
  CHECK(std::isnan(at<float>(picture_message({}, "file"), 40)));
}

TEST_CASE("What a coarse level errs is known from the last view that was refined") {
  PictureMaker maker(3);
  const auto make = [&](RenderedPicture picture) {
    maker.make(picture);
    maker.learn(picture);
    return picture.head.rmse;
  };
  CHECK(std::isnan(make(grey(8, 0.0F, 0, 1))));
  CHECK(make(grey(16, 1.0F, 2, 1)) == 0);
  CHECK(make(grey(8, 0.5F, 0, 2)) == 255);
  CHECK(std::isnan(make(grey(8, 0.5F, 1, 2))));
  // The view was left before it was refined: nothing new is known.
  CHECK(make(grey(16, 0.5F, 2, 3)) == 0);
  CHECK(make(grey(8, 0.5F, 0, 3)) == 255);
}

TEST_CASE("Enlarging a smooth picture costs no error") {
  std::vector<std::uint8_t> small, large;
  for (int k = 0; k < 8; ++k) small.insert(small.end(), 3, static_cast<std::uint8_t>(10 + 20 * k));
  for (int k = 0; k < 16; ++k) large.insert(large.end(), 3, static_cast<std::uint8_t>(5 + 10 * k));
  CHECK(rmse_of(small, 8, 1, large, 16, 1) < 2.0F);
  CHECK(rmse_of(large, 16, 1, large, 16, 1) == 0.0F);
}

TEST_CASE("Pictures are JPEGs over the background") {
  PictureMaker maker(1);
  RenderedPicture picture = grey(16, 0, 0, 1);
  picture.head.levels = 1;
  const std::string message = maker.make(picture);
  CHECK(message.substr(48, 3) == "\xff\xd8\xff");
  CHECK(at<std::uint16_t>(message, 16) == 16);
}

#include "app/image_difference.hpp"

#include <cmath>
#include <random>

#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

Image noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(0, 1);
  Image image(width, height);
  for (float& v : image.rgba) v = value(random);
  return image;
}

}  // namespace

TEST_CASE("equal pictures do not differ") {
  const Image a = noise(40, 30, 1);
  const auto d = difference(a, a, 4, 0);
  CHECK(d.total.rmse == 0);
  CHECK(d.total.largest == 0);
  CHECK(d.pixels_over == 0);
  CHECK(std::isinf(d.total.psnr()));
}

TEST_CASE("one pixel in a thousand that is off by 3/255 is found") {
  const Image a = noise(100, 100, 2);
  Image b = a;
  for (int k = 0; k < 10; ++k) b.pixel(7 * k, 9 * k + 3)[1] -= 3.0F / 255;
  const auto d = difference(a, b, 4, 1);
  CHECK(d.total.largest == Approx(3).epsilon(1e-4));
  CHECK(d.pixels_over == 10);
  CHECK(d.fraction_over() == Approx(0.001));
  CHECK(d.total.rmse == Approx(std::sqrt(10 * 9.0 / 40000)).epsilon(1e-4));
  CHECK(d.channels[1].rmse == Approx(std::sqrt(10 * 9.0 / 10000)).epsilon(1e-4));
  CHECK(d.channels[0].rmse == 0);
  CHECK(d.total.mean > 0);
  CHECK(difference(a, b, 4, 4).pixels_over == 0);
}

TEST_CASE("a change of brightness shows in the signed mean") {
  const Image a = noise(64, 64, 3);
  Image b = a;
  for (float& v : b.rgba) v *= 1.005F;
  const auto d = difference(b, a, 3, 1);
  CHECK(d.channel_count == 3);
  CHECK(d.total.mean == Approx(0.005 * 255 * 0.5).epsilon(0.05));
}

TEST_CASE("the worst pixel is named") {
  const Image a(20, 10);
  Image b = a;
  b.pixel(13, 7)[2] = 0.5F;
  const auto d = difference(a, b, 4, 1);
  CHECK(d.largest_x == 13);
  CHECK(d.largest_y == 7);
}

TEST_CASE("a value that is no number differs infinitely from one that is") {
  Image a(4, 4), b(4, 4);
  a.pixel(1, 1)[0] = NAN;
  CHECK(std::isinf(difference(a, b, 4, 1).total.rmse));
  b.pixel(1, 1)[0] = NAN;
  CHECK(difference(a, b, 4, 1).total.rmse == 0);
}

TEST_CASE("the difference picture is signed or absolute") {
  Image a(1, 1), b(1, 1);
  a.rgba = {0.25F, 0.5F, 0, 1};
  b.rgba = {0.5F, 0.25F, 0, 0.5F};
  CHECK(difference_image(a, b, 2, false).rgba == std::vector<float>{-0.5F, 0.5F, 0, 1});
  CHECK(difference_image(a, b, 2, true).rgba == std::vector<float>{0.5F, 0.5F, 0, 1});
}

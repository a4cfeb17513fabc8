#include "study/difference_image.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

TEST_CASE("the difference picture is signed or absolute") {
  Image a(1, 1), b(1, 1);
  a.rgba = {0.25F, 0.5F, 0, 1};
  b.rgba = {0.5F, 0.25F, 0, 0.5F};
  CHECK(difference_image(a, b, 2, false).rgba == Image::Floats{-0.5F, 0.5F, 0, 1});
  CHECK(difference_image(a, b, 2, true).rgba == Image::Floats{0.5F, 0.5F, 0, 1});
}

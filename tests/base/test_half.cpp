#include <cmath>

#include "base/half.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("finite halves keep their bits, and numbers between two go to the nearest, ties to the even one") {
  constexpr std::uint16_t infinity = 0x7c00;
  for (std::uint16_t half = 0; half < infinity; ++half) {
    const float here = from_half(half);
    REQUIRE(to_half(here) == half);
    if (half + 1 == infinity) break;
    const float next = from_half(std::uint16_t(half + 1)), middle = 0.5F * (here + next);
    REQUIRE(next > here);
    REQUIRE(to_half(middle) == half + half % 2);
    REQUIRE(to_half(std::nextafter(middle, 0.0F)) == half);
    REQUIRE(to_half(std::nextafter(middle, next)) == half + 1);
  }
  CHECK(from_half(1) == 0x1p-24F);
  CHECK(from_half(0x3c00) == 1.0F);
  CHECK(from_half(infinity - 1) == 65504.0F);
}

#include <limits>

#include "base/process.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("denormal floats are kept where volumes are read, and flushed again afterwards") {
  volatile float least = std::numeric_limits<float>::min();
  const PlainFloats tests_as_before;
  CHECK(least / 2 > 0);
  flush_denormals();
  CHECK(least / 2 == 0);
  {
    const PlainFloats kept;
    CHECK(least / 2 > 0);
  }
  CHECK(least / 2 == 0);
}

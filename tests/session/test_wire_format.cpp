#include "session/render.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("the wire format is sixteen digits") {
  const std::string format = wire_format();
  CHECK(format.size() == 16);
  CHECK(format.find_first_not_of("0123456789abcdef") == std::string::npos);
}

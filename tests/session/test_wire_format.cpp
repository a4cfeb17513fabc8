#include "session/wire_format.hpp"

#include "session/wire_hash.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

struct Pair {
  std::uint32_t first = 0, second = 0;
};
struct Swapped {
  std::uint32_t second = 0, first = 0;
};
struct Wide {
  std::uint32_t first = 0;
  std::uint64_t second = 0;
};

template <std::size_t Padding, class Struct>
std::uint64_t layout_of() {
  WireHash hash;
  hash.layout<Padding>(&Struct::first, &Struct::second);
  return hash.value();
}

enum class Early { one, two };
enum class Late { two, one };

template <class Enum>
std::uint64_t order_of() {
  WireHash hash;
  hash.order({Enum::one, Enum::two});
  return hash.value();
}

}  // namespace

TEST_CASE("the wire format is sixteen digits, the same whenever it is asked for") {
  const std::string format = wire_format();
  CHECK(format.size() == 16);
  CHECK(format.find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(wire_format() == format);
}

TEST_CASE("members that change places or grow change a layout's hash, and choices in another order theirs") {
  CHECK(layout_of<0, Pair>() == layout_of<0, Pair>());
  CHECK(layout_of<0, Pair>() != layout_of<0, Swapped>());
  CHECK(layout_of<0, Pair>() != layout_of<4, Wide>());
  CHECK(order_of<Early>() != order_of<Late>());
}

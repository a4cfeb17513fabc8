#pragma once
#include <string>
#include <vector>

namespace ringsplat {

/// Something that several processes must see, or have been told, alike: in words for people, so that a
/// difference can be shown as it is.
struct Fact {
  std::string field, value;
  bool operator==(const Fact&) const = default;
};
using Facts = std::vector<Fact>;

}  // namespace ringsplat

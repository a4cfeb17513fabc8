#pragma once
#include <string>
#include <vector>

namespace ringsplat {

/// Something that must be the same on several processes, in words for people, so that a difference can be
/// shown as it is.
struct Fact {
  std::string field, value;
  bool operator==(const Fact&) const = default;
};
using Facts = std::vector<Fact>;

}  // namespace ringsplat

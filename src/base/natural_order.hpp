#pragma once
#include <cstring>
#include <string>

namespace ringsplat {

/// True when `a` comes before `b` as people count: slice2 before slice10, as runs of digits are compared as
/// numbers; those with a zero in front come first.
inline bool naturally_before(const std::string& a, const std::string& b) {
  return strverscmp(a.c_str(), b.c_str()) < 0;
}

}  // namespace ringsplat

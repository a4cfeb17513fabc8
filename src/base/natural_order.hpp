#pragma once
#include <string>

namespace ringsplat {

/// True when `a` comes before `b` as people count: slice2 before slice10, as runs of digits are compared as
/// numbers.
bool naturally_before(const std::string& a, const std::string& b);

}  // namespace ringsplat

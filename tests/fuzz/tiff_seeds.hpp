#pragma once
#include <vector>

#include "fuzz/driver.hpp"

namespace ringsplat::fuzz {

/// Small TIFF stacks: either byte order, one or more strips, tiles, packed with PackBits or deflate; and a
/// PNG file.
std::vector<Input> tiff_seeds();

}  // namespace ringsplat::fuzz

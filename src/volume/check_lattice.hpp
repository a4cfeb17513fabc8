#pragma once
#include <string>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// check() of a grid but for its spacing, which --spacing may replace: open_volume() checks that.
void check_lattice(const Grid& grid, const std::string& where);

}  // namespace ringsplat::detail

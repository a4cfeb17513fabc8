#pragma once
#include <vector>

#include "fuzz/driver.hpp"

namespace ringsplat::fuzz {

/// Small HDF5 files: every layout, the old and the new format, and each convention.
std::vector<Input> hdf5_seeds();

}  // namespace ringsplat::fuzz

#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/strides.hpp"

namespace ringsplat::python {

/// A volume in the caller's memory, which must outlive all that reads it.
struct ArrayVolume {
  Grid grid;
  const std::byte* first_voxel = nullptr;  ///< (0, 0, 0), a scalar in native byte order, aligned or not
  Strides strides;
  VolumeNotes notes;
};

/// Throws InputError when the grid is none.
std::unique_ptr<VolumeSource> array_source(const ArrayVolume& volume);

}  // namespace ringsplat::python

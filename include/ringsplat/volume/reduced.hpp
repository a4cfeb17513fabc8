#pragma once
#include <memory>

#include "ringsplat/volume/source.hpp"

namespace ringsplat {

/// How a volume is made smaller for a quick picture (Neumann 1992, section 4.4).
struct Reduction {
  int factor = 1;          ///< voxels of the volume for one of the reduced one, along each axis
  bool prefilter = false;  ///< the mean of factor³ voxels (Williams 1983: a pyramid's level), or every factor-th voxel
  bool operator==(const Reduction&) const = default;
};

/// The lattice of the reduced volume: dimensions divided and rounded up, spacing multiplied. A mean lies in the middle of its
/// voxels. Throws InputError for a factor below 1.
Grid reduced_grid(const Grid& grid, const Reduction& reduction);

/// Reads the reduced volume from `full`, which must outlive it; each of its slices once, in ascending order. Means are
/// rounded to the scalar type; not-a-number takes no part in them. At the volume's end a mean is of the voxels there are.
std::unique_ptr<VolumeSource> reduced_source(VolumeSource& full, const Reduction& reduction);

}  // namespace ringsplat

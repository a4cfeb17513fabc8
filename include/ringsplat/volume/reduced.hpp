#pragma once
#include <memory>

#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat {

/// How a volume is made smaller for a quick picture (Neumann 1992, section 4.4).
struct Reduction {
  int factor = 1;          ///< voxels of the volume for one of the reduced one, along each axis
  bool prefilter = false;  ///< true: a level of a pyramid (Williams 1983); false: every factor-th voxel
  bool operator==(const Reduction&) const = default;
};

/// The lattice of the reduced volume: dimensions divided and rounded up, spacing multiplied. A prefiltered
/// voxel lies in the middle of those it stands for. Throws InputError for a factor below 1.
Grid reduced_grid(const Grid& grid, const Reduction& reduction);

/// The reduced source's VolumeSource::layer_depth(), for one that has `depth`. A prefilter also reaches into
/// the layers beside.
int reduced_layer_depth(int depth, const Reduction& reduction);

/// The part of the reduced volume that a box of the volume shows: voxels whose places lie in the box, at
/// least the one nearest to its middle. Where the box reaches the volume's face the part reaches the reduced
/// one's.
VoxelBox reduced_box(const VoxelBox& box, const Grid& grid, const Reduction& reduction);

/// Reads the reduced volume from `full`, which must outlive it. Read its slices in ascending order: then each
/// slice of `full` is read once. Throws InputError for a factor other than 2 or 4 with a prefilter.
///
/// The prefilter halves, once or twice: (−1 9 9 −1) / 16 along each axis, which is cubic interpolation at the
/// middle, limited to the range of the eight voxels. A mean of eight blurs more, and on the head its picture
/// errs more than skipping does. Values are rounded to the scalar type. Where a tap is not a number, the
/// voxel is the mean of the numbers among the eight. Beyond the border the outermost voxels are repeated.
std::unique_ptr<VolumeSource> reduced_source(VolumeSource& full, const Reduction& reduction);

}  // namespace ringsplat

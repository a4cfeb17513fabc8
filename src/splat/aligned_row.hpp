#pragma once
#include <vector>

#include "ringsplat/splat/aligned_slice.hpp"
#include "ringsplat/splat/region_painter.hpp"
#include "ringsplat/splat/voxel_run.hpp"
#include "splat/slice_buffer.hpp"
#include "splat/stencil.hpp"

namespace ringsplat {

/// Neighbouring voxels of a row whose windows all meet the region.
struct AlignedRow {
  int x, y;  ///< anchor of the first, from the region's corner
  const VoxelColour* voxels;
  int count;
};

/// Adds the voxels to the slice buffer as draw_with_stencil does: the same operations in the same order in
/// every pixel, but for additions of zero. Prepared as for draw_with_stencil. A voxel whose opacity is no
/// number that a footprint can give adds nothing. `scratch` is only kept to spare its allocation.
DrawCounts draw_aligned(const SliceBuffer& buffer, const AlignedSlice& slice, const AlignedRow& row,
                        std::vector<float>& scratch);

}  // namespace ringsplat

#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "splat/frame_kernel.hpp"

namespace ringsplat {

/// What the kernels of a slice have in common where its voxels lie a whole number of pixels apart, as in an
/// image in the slices' plane: all cover the pixels round their anchors with the same weights, so that
/// drawing a row of voxels is a convolution, as resampling a scanline is in Lacroute and Levoy 1994
/// (section 3.1).
struct AlignedSlice {
  /// Pixels from voxel to voxel, along u, which is right, and along v, which is down: 1, 2 or 4.
  int step_x = 1, step_y = 1;
  std::int64_t anchor_x = 0, anchor_y = 0;  ///< of voxel (0, 0), a pixel of the plane
  int reach_x = 1, reach_y = 1;             ///< as in KernelReach
  /// Columns and rows with a weight above zero, of those from reach before the anchor on. A kernel covers the
  /// whole window only where its voxel lies half-way between pixels.
  int first_column = 0, end_column = 4, first_row = 0, end_row = 4;
  int taps = 4;         ///< voxels of a row that can reach one pixel
  int first_tap_x = 0;  ///< from a pixel to the leftmost of them, in pixels
  /// [rows][taps][7 pixels][4]: the tap-th voxel's weight (the leftmost is the first) in each pixel from
  /// reach_x before an anchor on, which is again what it is a step further; each weight four times, once for
  /// each channel.
  std::vector<float> weights;
  double opacity_weight = 1;  ///< Footprint::weight
  struct Offset {
    int x, y;
  };
  std::vector<Offset> covered;  ///< pixels with a weight above zero, from the anchor
};

/// Empty where the voxels do not lie so, or kernels are not drawn with a stencil of float32 weights. `view`:
/// of the lattice to the image plane. The weights are the bits that RegionPainter::draw computes for each
/// splat of the slice.
std::optional<AlignedSlice> make_aligned_slice(const FrameKernel& kernel, const ViewTransform& view,
                                               Axis axis, int slice);

}  // namespace ringsplat

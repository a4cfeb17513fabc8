#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "splat/footprint.hpp"
#include "splat/splat.hpp"

namespace ringsplat {

/// Floats of one tap's weights in AlignedSlice. They serve a pixel block that begins at any pixel of a step.
inline constexpr int tap_floats = 4 * (block_pixels + largest_step - 1);

/// The kernels' weights in a slice whose voxels lie a whole number of pixels apart, as in an image in the
/// slices' plane. All kernels cover the pixels round their anchors with the same weights, so drawing a row of
/// voxels is a convolution, like resampling a scanline in Lacroute and Levoy 1994 (section 3.1).
struct AlignedSlice {
  /// Pixels from voxel to voxel: to the right along u, down along v. Each is 1, 2 or 4.
  int step_x = 1, step_y = 1;
  std::int64_t anchor_x = 0, anchor_y = 0;  ///< of voxel (0, 0), in pixels of the image plane
  int reach_x = 1, reach_y = 1;             ///< as in KernelReach
  /// Columns and rows of the window that have a weight above zero, counted from its first. A kernel fills the
  /// window only where its voxel lies half-way between pixels.
  int first_column = 0, end_column = 4, first_row = 0, end_row = 4;
  int taps = 4;         ///< voxels of a row that can reach one pixel
  int first_tap_x = 0;  ///< offset from a pixel to the leftmost of them, in pixels
  /// [rows][taps][7 pixels][4 channels]: weight of the tap-th voxel, counted from the leftmost, in each pixel
  /// from reach_x before an anchor on. Weights repeat after a step, and each is there once a channel.
  std::vector<float> weights = {};
  double opacity_weight = 1;             ///< Footprint::weight
  std::vector<glm::ivec2> covered = {};  ///< pixels with a weight above zero, as offsets from the anchor
};

/// A frame whose slices are all aligned, and whose kernels are drawn with a stencil.
struct AlignedFrame {
  /// Empty unless u goes right and v down, and both steps are 1, 2 or 4 pixels.
  static std::optional<AlignedFrame> of(const Footprint& footprint, const ViewTransform& view, Axis axis);
  /// The weights have the bits that SplatSum computes for each splat of the slice.
  AlignedSlice slice(int index) const;

  Footprint footprint;
  ViewTransform view;  ///< of the lattice to the image plane
  Axis axis;
  glm::ivec2 steps;  ///< pixels from voxel to voxel along u and v
};

}  // namespace ringsplat

#pragma once
#include "screen/pixel_window.hpp"
#include "sheet_engine/sheet_frame.hpp"

namespace ringsplat {

/// The pixels that a block of 8 x 8 voxels can be used for, or a block of cells be seen in.
class BlockWindows {
 public:
  /// `around`: how far from a block's voxels, in lattice distances, positions in its plane and slices before
  /// and after it count.
  BlockWindows(const FrameGeometry& geometry, double around, double slices_before, double slices_after);
  /// Of block (column, row) of a slice.
  PixelWindow of(int column, int row, int slice) const;

 private:
  glm::dvec2 first_, column_, row_, slice_, half_;
};

}  // namespace ringsplat

#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "screen/regions.hpp"
#include "sheet_engine/sheet_frame.hpp"

namespace ringsplat {

/// The pixels that a block of 8 x 8 voxels can be used for, or a block of cells be seen in.
class BlockWindows {
 public:
  /// `around`: how far from a block's voxels, in lattice distances, positions in its plane and slices before
  /// and after it count. `finer`: how many times as many voxels the slices are taken to have along each side.
  BlockWindows(const FrameGeometry& geometry, double around, double slices_before, double slices_after,
               int finer = 1);
  /// Of block (column, row) of a slice.
  PixelWindow of(int column, int row, int slice) const;
  /// Among so many columns and rows of a slice's blocks, those that these pixels may show, and some beside.
  PixelRect blocks_in(const PixelWindow& pixels, int slice, int columns, int rows) const;

 private:
  PixelWindow seen_from_eye(const glm::dvec3& centre) const;

  bool from_eye_;
  /// Of a block's centre, with z = 1; from an eye, places times their depth, with z the depth.
  glm::dvec3 first_, column_, row_, slice_;
  glm::dvec2 half_;      ///< a block's reach in an orthographic view
  glm::dvec3 reach_[3];  ///< a block's reach along u, v and k from an eye
};

/// The pixels in which what lies between slices is seen, by the blocks of a slice's cells.
struct SlabWindows {
  /// `finer`: as of BlockWindows.
  explicit SlabWindows(const FrameGeometry& geometry, int finer = 1);
  /// Of the slab behind the slice of `step`, as rays go through it.
  const BlockWindows& behind(int step) const { return step == slices - 1 ? after_last : between_slices; }

  int slices;
  BlockWindows between_slices, before_first, after_last;
};

}  // namespace ringsplat

#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sheet_engine/transparent_values.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// What can be seen of a block of 8 x 8 voxels.
struct BlockState {
  static constexpr int not_a_number = TransparentValues::most;
  bool needed = false;         ///< interpolation or gradients in visible cells use its voxels
  bool visible_above = false;  ///< its cells between this slice and the next can be visible
  bool visible_below = false;  ///< its cells between this slice and the one before can be visible
  std::uint8_t transparent =
      0;  ///< of one that is not needed: the interval of TransparentValues that holds it
};

/// The blocks of a GP's slices, or of their parts in a box, as a picture shows them: found when a slice is
/// first asked for, and again when the transparent values or the box have changed. Blocks are counted from
/// the box's corner; what is known of them are the ranges of the whole slices' blocks of cells that they
/// overlap.
class SliceBlocks {
 public:
  /// By block, row by row. `slice`: in the box. `reach`: SheetFrame::reach(). Valid until the next call with
  /// other transparent values or another box. The store must know the ranges of the axis's cells.
  std::span<const BlockState> of(const SliceStore& store, const VoxelBox& box, Axis axis, int slice,
                                 int reach, const TransparentValues& transparent);

 private:
  const std::vector<std::uint8_t>& visible(const SliceStore& store, Axis axis, int slice);
  std::vector<BlockState> find(const SliceStore& store, Axis axis, int slice, int reach);

  VoxelBox box_;
  TransparentValues transparent_;
  std::array<std::array<std::vector<std::vector<BlockState>>, 3>, 3> blocks_;  ///< by reach, axis and slice
  /// By axis and slice + 1: whether each block of the cells between the slice and the next can be visible.
  std::array<std::vector<std::vector<std::uint8_t>>, 3> visible_;
};

/// By slice of the box, whether any GP may have a needed block of it. A frame may ask while the one before it
/// is encoded.
std::vector<bool> shown_slices(const SliceStore& store, const VoxelBox& box, Axis axis, int reach,
                               const TransparentValues& transparent);

}  // namespace ringsplat

#include "sheet_engine/slice_blocks.hpp"

#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

/// What the ranges of a whole slice's cells say of the blocks of its part in a box.
class PartRanges {
 public:
  /// Slice `slice` of the box.
  PartRanges(const SliceStore& store, const VoxelBox& box, Axis axis, int slice)
      : ranges_(*store.cell_ranges(axis, box.first[static_cast<int>(axis)] + slice)),
        first_{box.first[in_plane(axis).u], box.first[in_plane(axis).v]},
        last_{box.end[in_plane(axis).u] - 1, box.end[in_plane(axis).v] - 1} {}

  /// low > high: no value of the block is a number.
  CellRanges::Range range(int column, int row) const {
    const auto [left, right] = overlapped(column, 0);
    const auto [top, bottom] = overlapped(row, 1);
    CellRanges::Range all = ranges_.range(left, top);
    for (int y = top; y <= bottom; ++y)
      for (int x = left; x <= right; ++x) all = hull(all, ranges_.range(x, y));
    return all;
  }
  static CellRanges::Range hull(const CellRanges::Range& a, const CellRanges::Range& b) {
    if (!(a.low <= a.high)) return b;
    if (!(b.low <= b.high)) return a;
    return {std::min(a.low, b.low), std::max(a.high, b.high)};
  }

 private:
  /// The first and the last of the whole slice's blocks that have cells of a block of the part.
  std::pair<int, int> overlapped(int block, int along) const {
    const int first = first_[std::size_t(along)] + block * CellRanges::side,
              last = std::min(first + CellRanges::side - 1, last_[std::size_t(along)]);
    return {first / CellRanges::side, last / CellRanges::side};
  }

  const CellRanges& ranges_;
  std::array<int, 2> first_, last_;  ///< voxels of the part
};

int columns_of(const VoxelBox& box, Axis axis) {
  return CellRanges::blocks_along(box.dims()[in_plane(axis).u]);
}
int rows_of(const VoxelBox& box, Axis axis) { return CellRanges::blocks_along(box.dims()[in_plane(axis).v]); }

/// Sets `needed` in every block next to a visible one.
void need_around(const std::vector<std::uint8_t>& visible, int columns, int rows,
                 std::vector<BlockState>& blocks) {
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      if (visible[std::size_t(row) * std::size_t(columns) + std::size_t(column)] == 0) continue;
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y)
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns - 1); ++x)
          blocks[std::size_t(y) * std::size_t(columns) + std::size_t(x)].needed = true;
    }
}

}  // namespace

/// Before the first slice and after the last one the field has the values of that slice.
const std::vector<std::uint8_t>& SliceBlocks::visible(const SliceStore& store, Axis axis, int s) {
  const int slices = box_.dims()[static_cast<int>(axis)], columns = columns_of(box_, axis),
            rows = rows_of(box_, axis);
  auto& of_axis = visible_[std::size_t(axis)];
  of_axis.resize(std::size_t(slices) + 1);
  std::vector<std::uint8_t>& visible = of_axis[std::size_t(s + 1)];
  if (!visible.empty()) return visible;
  visible.resize(std::size_t(columns) * std::size_t(rows));
  const PartRanges before(store, box_, axis, std::max(s, 0)),
      after(store, box_, axis, std::min(s + 1, slices - 1));
  for (int row = 0, k = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column, ++k) {
      const auto [low, high] = PartRanges::hull(before.range(column, row), after.range(column, row));
      visible[std::size_t(k)] = low <= high && transparent_.holding(low, high) == TransparentValues::nowhere;
    }
  return visible;
}

std::vector<BlockState> SliceBlocks::find(const SliceStore& store, Axis axis, int slice, int reach) {
  const int slices = box_.dims()[static_cast<int>(axis)], columns = columns_of(box_, axis),
            rows = rows_of(box_, axis);
  std::vector<BlockState> blocks(std::size_t(columns) * std::size_t(rows));
  for (int s = std::max(slice - reach, -1); s < std::min(slice + reach, slices); ++s) {
    const auto& seen = visible(store, axis, s);
    need_around(seen, columns, rows, blocks);
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      if (s == slice) blocks[k].visible_above = seen[k] != 0;
      if (s == slice - 1) blocks[k].visible_below = seen[k] != 0;
    }
  }
  const PartRanges ranges(store, box_, axis, slice);
  for (int row = 0, k = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column, ++k) {
      BlockState& block = blocks[std::size_t(k)];
      if (block.needed) continue;
      const auto [low, high] = ranges.range(column, row);
      block.transparent =
          std::uint8_t(low > high ? BlockState::not_a_number : transparent_.holding(low, high));
    }
  return blocks;
}

std::span<const BlockState> SliceBlocks::of(const SliceStore& store, const VoxelBox& box, Axis axis,
                                            int slice, int reach, const TransparentValues& transparent) {
  if (box != box_ || transparent != transparent_) {
    box_ = box;
    transparent_ = transparent;
    blocks_ = {};
    visible_ = {};
  }
  auto& slices = blocks_[std::size_t(reach)][std::size_t(axis)];
  slices.resize(std::size_t(box.dims()[static_cast<int>(axis)]));
  auto& blocks = slices[std::size_t(slice)];
  if (blocks.empty()) blocks = find(store, axis, slice, reach);
  return blocks;
}

std::vector<bool> shown_slices(const SliceStore& store, const VoxelBox& box, Axis axis, int reach,
                               const TransparentValues& transparent) {
  const int first = box.first[static_cast<int>(axis)], slices = box.dims()[static_cast<int>(axis)];
  const auto& known = store.ranges(axis);
  if (known.empty()) return std::vector<bool>(static_cast<std::size_t>(slices), true);
  const auto range_of = [&](int slice) -> const SliceRange& {
    return known[std::size_t(first + std::clamp(slice, 0, slices - 1))];
  };
  std::vector<bool> shown(std::size_t(slices), false);
  for (int s = -1; s < slices; ++s) {
    const SliceRange &before = range_of(s), &after = range_of(s + 1);
    const double low = std::min(before.low, after.low), high = std::max(before.high, after.high);
    if (!(low <= high) || transparent.holding(low, high) != TransparentValues::nowhere) continue;
    for (int z = std::max(s + 1 - reach, 0); z <= std::min(s + reach, slices - 1); ++z)
      shown[std::size_t(z)] = true;
  }
  return shown;
}

}  // namespace ringsplat

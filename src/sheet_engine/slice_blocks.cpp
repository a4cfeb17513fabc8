#include "sheet_engine/slice_blocks.hpp"

#include <algorithm>

#include "volume/cell_ranges.hpp"
#include "volume/slice_ranges.hpp"

namespace ringsplat {
namespace {

/// Whether each block of the cells between slices `s` and `s + 1` can be visible. Before the first slice and
/// after the last one the field has the values of that slice.
std::vector<std::uint8_t> visible_cells(const SliceStore& store, Axis axis, int s, int slices,
                                        const TransparentValues& transparent) {
  const CellRanges* before = store.cell_ranges(axis, std::max(s, 0));
  const CellRanges* after = store.cell_ranges(axis, std::min(s + 1, slices - 1));
  const Grid& grid = store.grid();
  const int columns = CellRanges::blocks_along(grid.slice_width(axis)),
            rows = CellRanges::blocks_along(grid.slice_height(axis));
  std::vector<std::uint8_t> visible(std::size_t(columns) * std::size_t(rows), 1);
  if (before == nullptr || after == nullptr) return visible;
  for (int row = 0, k = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column, ++k) {
      const auto [low, high] = before->range(column, row);
      const auto [other_low, other_high] = after->range(column, row);
      const double least = std::min(low, other_low), most = std::max(high, other_high);
      // A block without a number has least > most.
      visible[std::size_t(k)] =
          least <= most && transparent.holding(least, most) == TransparentValues::nowhere;
    }
  return visible;
}

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

void SliceBlocks::use(const TransferFunction& transfer_function) {
  if (known_ && transfer_function == transfer_function_) return;
  transfer_function_ = transfer_function;
  transparent_ = TransparentValues(transfer_function);
  for (auto& by_axis : blocks_)
    for (auto& by_slice : by_axis) by_slice.clear();
  known_ = true;
}

std::vector<BlockState> SliceBlocks::find(const SliceStore& store, Axis axis, int slice, int reach) const {
  const Grid& grid = store.grid();
  const int slices = grid.slices(axis);
  const int columns = CellRanges::blocks_along(grid.slice_width(axis)),
            rows = CellRanges::blocks_along(grid.slice_height(axis));
  std::vector<BlockState> blocks(std::size_t(columns) * std::size_t(rows));
  for (int s = std::max(slice - reach, -1); s < std::min(slice + reach, slices); ++s) {
    const auto visible = visible_cells(store, axis, s, slices, transparent_);
    need_around(visible, columns, rows, blocks);
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      if (s == slice) blocks[k].visible_above = visible[k] != 0;
      if (s == slice - 1) blocks[k].visible_below = visible[k] != 0;
    }
  }
  const CellRanges* ranges = store.cell_ranges(axis, slice);
  for (int row = 0, k = 0; ranges != nullptr && row < rows; ++row)
    for (int column = 0; column < columns; ++column, ++k) {
      BlockState& block = blocks[std::size_t(k)];
      if (block.needed) continue;
      const auto [low, high] = ranges->range(column, row);
      block.transparent =
          std::uint8_t(low > high ? BlockState::not_a_number : transparent_.holding(low, high));
    }
  return blocks;
}

std::span<const BlockState> SliceBlocks::of(const SliceStore& store, Axis axis, int slice, int reach,
                                            const TransferFunction& transfer_function) {
  use(transfer_function);
  auto& slices = blocks_[std::size_t(reach)][std::size_t(axis)];
  slices.resize(std::size_t(store.grid().slices(axis)));
  auto& blocks = slices[std::size_t(slice)];
  if (blocks.empty()) blocks = find(store, axis, slice, reach);
  return blocks;
}

std::vector<bool> SliceBlocks::shown_slices(const SliceStore& store, Axis axis, int reach,
                                            const TransferFunction& transfer_function) {
  use(transfer_function);
  const int slices = store.grid().slices(axis);
  const SliceRanges* known = store.ranges();
  if (known == nullptr || known->of(axis).empty())
    return std::vector<bool>(static_cast<std::size_t>(slices), true);
  const auto& ranges = known->of(axis);
  std::vector<bool> shown(std::size_t(slices), false);
  for (int s = -1; s < slices; ++s) {
    const SliceRange &before = ranges[std::size_t(std::max(s, 0))],
                     &after = ranges[std::size_t(std::min(s + 1, slices - 1))];
    const double low = std::min(before.low, after.low), high = std::max(before.high, after.high);
    if (!(low <= high) || transparent_.holding(low, high) != TransparentValues::nowhere) continue;
    for (int z = std::max(s + 1 - reach, 0); z <= std::min(s + reach, slices - 1); ++z)
      shown[std::size_t(z)] = true;
  }
  return shown;
}

}  // namespace ringsplat

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// A Renderer keeps slices' planes on shelves; those of a frame's slices are on one of them.
struct ShelfNumber {
  static constexpr int shelves = 8;
  std::uint8_t shelf = 0, live = 0;  ///< `live`: a bit for each shelf that is still needed
  std::uint16_t generation = 0;      ///< another one than before: what the shelf held is void
  bool operator==(const ShelfNumber&) const = default;
};
inline constexpr std::uint16_t no_plane = 0xffff;

/// A slice's payload for one Renderer: a SheetHeader, then for each of `rows` rows of blocks from `first_row`
/// on a BlockRow and a byte for each of its blocks, then the voxels of all present blocks that are not kept,
/// in order, each row by row in the volume's own type, and behind those of a labelled block its labels, of 8
/// bits. Blocks of which nothing is said are as `elsewhere`.
struct SheetHeader {
  double low = 0, high = 0;   ///< of the volume's (the level's) values; low > high: all are not-a-number
  std::uint32_t present = 0;  ///< blocks that can be seen
  std::uint16_t first_row = 0, rows = 0;
  std::uint8_t elsewhere = 0;      ///< a block byte without flags
  std::uint8_t scalar = 0;         ///< ScalarType
  std::uint16_t plane = no_plane;  ///< where on the shelf the Renderer keeps the slice
  ShelfNumber shelf;
};
static_assert(sizeof(SheetHeader) == 32);

struct BlockRow {
  std::uint16_t first = 0, end = 0;  ///< columns of blocks
};

/// A block's byte: the interval of transparent values that holds it (BlockState::transparent), or flags.
inline constexpr std::uint8_t block_present = 0x80;   ///< it can be seen; its voxels follow unless it is kept
inline constexpr std::uint8_t cells_visible = 0x40;   ///< its cells before the next step's slice may be seen
inline constexpr std::uint8_t block_kept = 0x20;      ///< its voxels are in the plane, from an earlier frame
inline constexpr std::uint8_t block_labelled = 0x10;  ///< its labels follow, too; else they are 0

/// A payload taken apart; its spans look into the payload.
struct SheetPayload {
  SheetHeader header;
  std::vector<BlockRow> rows;              ///< from header.first_row on
  std::vector<const std::uint8_t*> bytes;  ///< by row: those of blocks first ... end - 1
  std::span<const std::byte> voxels;
  std::uint32_t kept = 0;  ///< of the present blocks

  /// Calls `use` with the column, the row and the byte of each block of which something is said.
  void for_each_block(auto&& use) const {
    for (std::size_t k = 0; k < rows.size(); ++k)
      for (int column = rows[k].first; column < rows[k].end; ++column)
        use(column, header.first_row + int(k), bytes[k][column - rows[k].first]);
  }
};

/// Throws RunError unless `body` is a payload for slices of this width, height and type, and nothing else.
SheetPayload read_sheet_payload(std::span<const std::byte> body, int width, int height, ScalarType type);

}  // namespace ringsplat

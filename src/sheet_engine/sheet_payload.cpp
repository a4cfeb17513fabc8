#include "sheet_engine/sheet_payload.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/byte_stream.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

OtherBuild no_payload(const std::string& what) {
  return OtherBuild(fmt::format("a slice's payload {}", what));
}

}  // namespace

SheetPayload read_sheet_payload(std::span<const std::byte> body, int width, int height, ScalarType type) {
  constexpr int side = CellRanges::side;
  const int columns = CellRanges::blocks_along(width), block_rows = CellRanges::blocks_along(height);
  SheetPayload payload;
  SheetHeader& header = payload.header;
  std::size_t at = 0;
  if (!take(body, at, header)) throw no_payload("ends within its header");
  if (header.scalar != std::uint8_t(type)) throw no_payload("is of another type of voxels");
  if (header.first_row + header.rows > block_rows || header.elsewhere > BlockState::not_a_number)
    throw no_payload("has rows of blocks outside the slice");
  if (header.shelf.shelf >= ShelfNumber::shelves) throw no_payload("is for a shelf that there is not");
  std::uint32_t present = 0;
  std::size_t bytes_of_voxels = 0;
  for (int row = 0; row < header.rows; ++row) {
    BlockRow& blocks = payload.rows.emplace_back();
    if (!take(body, at, blocks) || blocks.first > blocks.end || blocks.end > columns ||
        std::size_t(blocks.end - blocks.first) > body.size() - at)
      throw no_payload("has a row of blocks outside the slice");
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(body.data() + at);
    payload.bytes.push_back(bytes);
    at += std::size_t(blocks.end - blocks.first);
    const int rows_here = std::min(side, height - (header.first_row + row) * side);
    for (int column = blocks.first; column < blocks.end; ++column) {
      const std::uint8_t byte = bytes[column - blocks.first];
      const int flags = cells_visible | ((byte & block_kept) == 0 ? block_labelled : 0) |
                        (header.plane != no_plane ? block_kept : 0);
      if ((byte & ~flags) != block_present && byte > BlockState::not_a_number)
        throw no_payload("says of a block what cannot be");
      if (byte < block_present) continue;
      ++present;
      if ((byte & block_kept) != 0) {
        ++payload.kept;
        continue;
      }
      const auto here = std::size_t(rows_here) * std::size_t(std::min(side, width - column * side));
      bytes_of_voxels += here * (size_of(type) + ((byte & block_labelled) != 0 ? 1 : 0));
    }
  }
  if (present != header.present || body.size() - at != bytes_of_voxels)
    throw no_payload(fmt::format("has {} bytes of voxels where {} blocks have {}", body.size() - at, present,
                                 bytes_of_voxels));
  payload.voxels = body.subspan(at);
  return payload;
}

}  // namespace ringsplat

#include "scene/voxel_blocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>

#include "base/byte_stream.hpp"
#include "net/blocks.hpp"
#include "ringsplat/base/error.hpp"
#include "scene/block_cover.hpp"

namespace ringsplat {
namespace {

constexpr const char* builds_differ = "all ranks must run the same build";

/// Rows [y, y_end) of a block in slice z.
struct Rows {
  int block, z, y, y_end;
};

/// Begins a message's rows of voxels.
struct RowsHeader {
  std::int32_t z, y, y_end, x, x_end;
};

std::string why_wrong(const Grid& grid, const std::vector<VoxelBlock>& blocks) {
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    try {
      check(blocks[k].extent, grid);
    } catch (const InputError& e) {
      return fmt::format("block {}: {}", k, e.what());
    }
    if (blocks[k].first_voxel == nullptr)
      return fmt::format(
          "block {} has no voxels: its pointer is null; hint: pass where the voxel extent.first lies", k);
  }
  return {};
}

std::vector<PlacedBlock> gather_extents(const std::vector<VoxelBlock>& mine, Collectives& collectives) {
  std::vector<VoxelBox> extents;
  for (const VoxelBlock& block : mine) extents.push_back(block.extent);
  std::vector<PlacedBlock> placed;
  int process = 0;
  for (const Block& one : collectives.all_gather(block_of(std::as_bytes(std::span(extents))))) {
    int number = 0;
    for (std::size_t at = 0; at < one.size(); ++number) {
      VoxelBox extent;
      if (!take(one, at, extent)) throw RunError("a process sent a part of a block's extent", builds_differ);
      placed.push_back({extent, process, number});
    }
    ++process;
  }
  return placed;
}

/// Copies a row of scalars that lie `stride` bytes apart.
template <std::size_t bytes>
void copy_row(const std::byte* from, std::int64_t stride, int count, std::byte* to) {
  if (stride == std::int64_t(bytes)) {
    std::memcpy(to, from, bytes * std::size_t(count));
    return;
  }
  for (int k = 0; k < count; ++k, from += stride, to += bytes) std::memcpy(to, from, bytes);
}

void copy_row(std::size_t bytes, const std::byte* from, std::int64_t stride, int count, std::byte* to) {
  if (bytes == 1) return copy_row<1>(from, stride, count, to);
  if (bytes == 2) return copy_row<2>(from, stride, count, to);
  if (bytes == 4) return copy_row<4>(from, stride, count, to);
  copy_row<8>(from, stride, count, to);
}

class BlockDealer {
 public:
  BlockDealer(const Grid& grid, const std::vector<VoxelBlock>& mine, std::map<int, SliceStore>& stores,
              int gps, const std::vector<std::vector<int>>& gps_of_process, std::size_t round_bytes,
              Collectives& collectives)
      : grid_(grid),
        blocks_(mine),
        stores_(stores),
        gps_(gps),
        round_bytes_(round_bytes),
        collectives_(collectives),
        process_of_slice_(std::size_t(grid.dims.z)),
        scalar_(size_of(grid.type)) {
    std::vector<int> process_of_gp(std::size_t(gps), 0);
    for (std::size_t p = 0; p < gps_of_process.size(); ++p)
      for (const int gp : gps_of_process[p]) process_of_gp[std::size_t(gp)] = int(p);
    for (int z = 0; z < grid.dims.z; ++z)
      process_of_slice_[std::size_t(z)] = process_of_gp[std::size_t(SliceStore::owner_of(z, gps))];
  }

  /// In a round process p sends to p + d, p + d + 1 … and gets from p − d, p − d − 1 …: as many of them as
  /// fit into a round, or a part of what one of them gets.
  void run() {
    const int processes = collectives_.processes();
    const std::uint64_t most = agree_on_most();
    const int at_once = int(std::clamp<std::uint64_t>(round_bytes_ / std::max<std::uint64_t>(1, most), 1,
                                                      std::uint64_t(processes)));
    for (int first = 0; first < processes; first += at_once) {
      const int end = std::min(processes, first + at_once);
      std::vector<std::vector<Rows>> left(std::size_t(end - first));
      for (int d = first; d < end; ++d) left[std::size_t(d - first)] = rows_for(destination(d));
      bool more = true;
      while (more) {
        std::vector<Block> out(static_cast<std::size_t>(processes));
        for (int d = first; d < end; ++d)
          out[std::size_t(destination(d))] = packed(left[std::size_t(d - first)]);
        more = at_once == 1 && any(!left.front().empty());
        for (const Block& in : collectives_.all_to_all(std::move(out))) place(in);
      }
    }
  }

 private:
  int destination(int distance) const {
    return (collectives_.process() + distance) % collectives_.processes();
  }

  std::size_t bytes_of(const Rows& rows) const {
    const int width = blocks_[std::size_t(rows.block)].extent.dims().x;
    return sizeof(RowsHeader) + std::size_t(rows.y_end - rows.y) * std::size_t(width) * scalar_;
  }

  /// What this process has for another, in the last first order, cut so that none is larger than a round.
  std::vector<Rows> rows_for(int process) const {
    std::vector<Rows> all;
    for (int b = int(blocks_.size()) - 1; b >= 0; --b) {
      const VoxelBox& box = blocks_[std::size_t(b)].extent;
      const auto row = std::size_t(box.dims().x) * scalar_;
      const auto fitting = (round_bytes_ - std::min(round_bytes_, sizeof(RowsHeader))) / row;
      const int rows = int(std::clamp<std::size_t>(fitting, 1, std::size_t(box.dims().y)));
      for (int z = box.end.z - 1; z >= box.first.z; --z)
        for (int y = box.first.y; process_of_slice_[std::size_t(z)] == process && y < box.end.y; y += rows)
          all.push_back({b, z, y, std::min(y + rows, box.end.y)});
    }
    return all;
  }

  /// The most that one process has for another.
  std::uint64_t agree_on_most() {
    std::vector<std::uint64_t> mine(std::size_t(collectives_.processes()), 0);
    for (const VoxelBlock& block : blocks_) {
      const glm::ivec3 dims = block.extent.dims();
      const auto slice = std::uint64_t(dims.x) * std::uint64_t(dims.y) * scalar_ + sizeof(RowsHeader);
      for (int z = block.extent.first.z; z < block.extent.end.z; ++z)
        mine[std::size_t(process_of_slice_[std::size_t(z)])] += slice;
    }
    std::uint64_t most = 0;
    for (const Block& one :
         collectives_.all_gather(block_of_value(*std::max_element(mine.begin(), mine.end()))))
      most = std::max(most, value_of<std::uint64_t>(one, "the bytes of its blocks"));
    return most;
  }

  bool any(bool mine) {
    bool any = false;
    for (const Block& one : collectives_.all_gather(Block{std::byte(mine)})) any |= one.at(0) != std::byte(0);
    return any;
  }

  /// Takes rows from the end of `left` until a round is full.
  Block packed(std::vector<Rows>& left) const {
    Block out;
    std::size_t size = 0, count = 0;
    while (count < left.size()) {
      const std::size_t bytes = bytes_of(left[left.size() - 1 - count]);
      if (count > 0 && size + bytes > round_bytes_) break;
      size += bytes;
      ++count;
    }
    out.resize(size);
    std::byte* to = out.data();
    for (; count > 0; --count) {
      to = pack(left.back(), to);
      left.pop_back();
    }
    return out;
  }

  std::byte* pack(const Rows& rows, std::byte* to) const {
    const auto& [extent, first, strides] = blocks_[std::size_t(rows.block)];
    const RowsHeader header{rows.z, rows.y, rows.y_end, extent.first.x, extent.end.x};
    std::memcpy(to, &header, sizeof header);
    to += sizeof header;
    const int width = extent.dims().x;
    for (int y = rows.y; y < rows.y_end; ++y, to += std::size_t(width) * scalar_)
      copy_row(scalar_, first + (rows.z - extent.first.z) * strides.z + (y - extent.first.y) * strides.y,
               strides.x, width, to);
    return to;
  }

  void place(std::span<const std::byte> in) {
    for (std::size_t at = 0; at < in.size();) {
      RowsHeader rows{};
      const bool whole = take(in, at, rows);
      const bool fits = whole && 0 <= rows.z && rows.z < grid_.dims.z && 0 <= rows.y && rows.y < rows.y_end &&
                        rows.y_end <= grid_.dims.y && 0 <= rows.x && rows.x < rows.x_end &&
                        rows.x_end <= grid_.dims.x;
      const auto store = fits ? stores_.find(SliceStore::owner_of(rows.z, gps_)) : stores_.end();
      const auto row = std::size_t(rows.x_end - rows.x) * scalar_;
      if (store == stores_.end() || in.size() - at < row * std::size_t(rows.y_end - rows.y))
        throw RunError("a rank sent rows of voxels that do not fit this rank's slices", builds_differ);
      std::byte* slice = store->second.values(Axis::z, rows.z).data();
      for (int y = rows.y; y < rows.y_end; ++y, at += row)
        std::memcpy(slice + (std::size_t(y) * std::size_t(grid_.dims.x) + std::size_t(rows.x)) * scalar_,
                    in.data() + at, row);
    }
  }

  const Grid& grid_;
  const std::vector<VoxelBlock>& blocks_;
  std::map<int, SliceStore>& stores_;
  int gps_;
  std::size_t round_bytes_;
  Collectives& collectives_;
  std::vector<int> process_of_slice_;
  std::size_t scalar_;
};

}  // namespace

void check_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, Collectives& collectives) {
  agree(collectives, why_wrong(grid, mine));
  const std::vector<PlacedBlock> all = gather_extents(mine, collectives);
  std::string error;
  try {
    for (const PlacedBlock& block : all) check(block.extent, grid);
    check_cover(grid, all);
  } catch (const InputError& e) {
    error = e.what();
  }
  agree(collectives, collectives.process() == 0 ? error : "");
}

void deal_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, std::map<int, SliceStore>& stores,
                 int gps, const std::vector<std::vector<int>>& gps_of_process, std::size_t round_bytes,
                 Collectives& collectives) {
  BlockDealer(grid, mine, stores, gps, gps_of_process, round_bytes, collectives).run();
}

}  // namespace ringsplat

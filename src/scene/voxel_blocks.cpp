#include "scene/dealer.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/text.hpp"
#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {

std::string text_of(const VoxelBox& box) {
  return fmt::format("{}:{},{}:{},{}:{}", box.first.x, box.end.x, box.first.y, box.end.y, box.first.z,
                     box.end.z);
}

namespace {

using Blocks = std::vector<PlacedBlock>;

std::string text_of(const PlacedBlock& block) {
  return fmt::format("block {} of rank {} ({})", block.number, block.process, text_of(block.extent));
}

bool covers(const VoxelBox& outer, const VoxelBox& inner) {
  return glm::all(glm::lessThanEqual(outer.first, inner.first)) &&
         glm::all(glm::greaterThanEqual(outer.end, inner.end));
}

/// A face of a block within the box, near the middle of all such faces of the axis that has most; there is
/// one unless every block covers the box. Returns the axis and the face's place.
std::pair<int, int> cut_of(const VoxelBox& box, const Blocks& blocks) {
  std::pair<int, int> cut;
  std::size_t most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<int> faces;
    for (const PlacedBlock& block : blocks)
      for (const int face : {block.extent.first[axis], block.extent.end[axis]})
        if (box.first[axis] < face && face < box.end[axis]) faces.push_back(face);
    if (faces.size() <= most) continue;
    most = faces.size();
    const auto middle = faces.begin() + std::ptrdiff_t(most / 2);
    std::nth_element(faces.begin(), middle, faces.end());
    cut = {axis, *middle};
  }
  return cut;
}

/// Rows [y, y_end) of a block in slice z.
struct Rows {
  int block, z, y, y_end;
};
using Parcel = std::vector<Rows>;

/// Begins rows of voxels in a parcel.
struct RowsHeader {
  std::int32_t z, y, y_end, x, x_end;
};

std::string why_wrong(const Grid& grid, const std::vector<VoxelBlock>& blocks) {
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const std::string wrong = input_error_of([&] { check(blocks[k].extent, grid); });
    if (!wrong.empty()) return fmt::format("block {}: {}", k, wrong);
    if (blocks[k].first_voxel == nullptr)
      return fmt::format(
          "block {} has no voxels: its pointer is null; hint: pass where the voxel extent.first lies", k);
  }
  return {};
}

struct BlockDealer {
  const Grid& grid;
  const std::vector<VoxelBlock>& blocks;
  std::map<int, SliceStore>& stores;
  std::size_t round_bytes;
  const Sharing& sharing;
  Collectives& collectives = sharing.collectives;
  std::size_t scalar = size_of(grid.type);

  /// Its own voxels first, without a message. Then in a round process p sends to p + d, p + d + 1 … and gets
  /// from p − d, p − d − 1 …: as many of them as fit into a round, or a part of what one of them gets.
  void run() {
    const int processes = collectives.processes();
    const std::uint64_t most = agree_on_most();
    const int at_once = int(std::clamp<std::uint64_t>(round_bytes / std::max<std::uint64_t>(1, most), 1,
                                                      std::uint64_t(processes)));
    for (const Parcel& parcel : parcels_for(collectives.process()))
      for (const Rows& rows : parcel)
        copy(rows, voxel(rows.z, rows.y, blocks[std::size_t(rows.block)].extent.first.x), slice_row());
    for (int first = 1; first < processes; first += at_once) {
      const int end = std::min(processes, first + at_once);
      std::vector<std::vector<Parcel>> parcels;
      for (int d = first; d < end; ++d) parcels.push_back(parcels_for(destination(d)));
      const auto rounds = at_once > 1 ? 1 : largest(parcels.front().size(), "the rounds it sends in");
      for (std::uint64_t round = 0; round < rounds; ++round) {
        std::vector<Block> out(static_cast<std::size_t>(processes));
        for (int d = first; d < end; ++d)
          if (const auto& all = parcels[std::size_t(d - first)]; round < all.size())
            out[std::size_t(destination(d))] = packed(all[round]);
        for (const Block& in : collectives.all_to_all(std::move(out))) place(in);
      }
    }
  }

  int destination(int distance) const { return (collectives.process() + distance) % collectives.processes(); }

  std::size_t bytes_of(const Rows& rows) const {
    const int width = blocks[std::size_t(rows.block)].extent.dims().x;
    return sizeof(RowsHeader) + std::size_t(rows.y_end - rows.y) * std::size_t(width) * scalar;
  }

  /// What this process has for another, a parcel a round: cut into quarters of it, which fill it well.
  std::vector<Parcel> parcels_for(int process) const {
    std::vector<Parcel> all;
    std::size_t bytes = 0;  // of the last
    const auto add = [&](const Rows& rows) {
      if (all.empty() || bytes + bytes_of(rows) > round_bytes) {
        all.emplace_back();
        bytes = 0;
      }
      all.back().push_back(rows);
      bytes += bytes_of(rows);
    };
    for (int b = 0; b < int(blocks.size()); ++b) {
      const VoxelBox& box = blocks[std::size_t(b)].extent;
      const auto row = std::size_t(box.dims().x) * scalar;
      const auto fitting = (round_bytes / 4 - std::min(round_bytes / 4, sizeof(RowsHeader))) / row;
      const int rows = int(std::clamp<std::size_t>(fitting, 1, std::size_t(box.dims().y)));
      for (int z = box.first.z; z < box.end.z; ++z)
        for (int y = box.first.y; sharing.process_of_slice(z) == process && y < box.end.y; y += rows)
          add({b, z, y, std::min(y + rows, box.end.y)});
    }
    return all;
  }

  /// The most that one process has for another.
  std::uint64_t agree_on_most() {
    std::vector<std::uint64_t> mine(std::size_t(collectives.processes()), 0);
    for (const VoxelBlock& block : blocks) {
      const glm::ivec3 dims = block.extent.dims();
      const auto slice = std::uint64_t(dims.x) * std::uint64_t(dims.y) * scalar + sizeof(RowsHeader);
      for (int z = block.extent.first.z; z < block.extent.end.z; ++z)
        mine[std::size_t(sharing.process_of_slice(z))] += slice;
    }
    return largest(*std::max_element(mine.begin(), mine.end()), "the bytes of its blocks");
  }

  std::uint64_t largest(std::uint64_t mine, const char* what) {
    std::uint64_t most = 0;
    for (const Block& one : collectives.all_gather(to_bytes(mine)))
      most = std::max(most, value_of<std::uint64_t>(one, what));
    return most;
  }

  Block packed(const Parcel& parcel) const {
    Block out;
    for (const Rows& rows : parcel) {
      const VoxelBox& extent = blocks[std::size_t(rows.block)].extent;
      append(out, RowsHeader{rows.z, rows.y, rows.y_end, extent.first.x, extent.end.x});
      const std::size_t at = out.size();
      out.resize(at + bytes_of(rows) - sizeof(RowsHeader));
      copy(rows, out.data() + at, std::size_t(extent.dims().x) * scalar);
    }
    return out;
  }

  /// Copies rows of voxels to where each lies `row` bytes behind the one before.
  void copy(const Rows& rows, std::byte* to, std::size_t row) const {
    const auto& [extent, first, strides] = blocks[std::size_t(rows.block)];
    for (int y = rows.y; y < rows.y_end; ++y, to += row)
      copy_row(scalar, first + (rows.z - extent.first.z) * strides.z + (y - extent.first.y) * strides.y,
               strides.x, extent.dims().x, to);
  }

  std::size_t slice_row() const { return std::size_t(grid.dims.x) * scalar; }

  /// Where a voxel of one of this process's slices lies.
  std::byte* voxel(int z, int y, int x) {
    std::byte* slice = stores.at(sharing.dealing.owner_of(z)).values(Axis::z, z).data();
    return slice + std::size_t(y) * slice_row() + std::size_t(x) * scalar;
  }

  void place(std::span<const std::byte> in) {
    for (std::size_t at = 0; at < in.size();) {
      const auto rows = next_value<RowsHeader>(in, at);
      const auto row = std::size_t(rows.x_end - rows.x) * scalar;
      std::byte* to = voxel(rows.z, rows.y, rows.x);
      for (int y = rows.y; y < rows.y_end; ++y, at += row, to += slice_row())
        std::memcpy(to, in.data() + at, row);
    }
  }
};

}  // namespace

void check_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, Collectives& collectives) {
  agree(collectives, why_wrong(grid, mine));
  const auto extents = detail::mapped(mine, &VoxelBlock::extent);
  std::vector<PlacedBlock> all;
  int process = 0;
  for (const Block& one : collectives.all_gather(to_bytes(extents))) {
    int number = 0;
    for (const VoxelBox& extent : value_of<std::vector<VoxelBox>>(one, "its blocks' extents"))
      all.push_back({extent, process, number++});
    ++process;
  }
  agree_after(collectives, [&] {
    if (collectives.process() == 0) check_cover(whole_box(grid), all);
  });
}

void check_cover(const VoxelBox& box, const Blocks& blocks) {
  if (blocks.empty())
    throw InputError(fmt::format("no block covers voxels {}", text_of(box)),
                     "all blocks together must cover the grid, ghosts left out");
  const auto whole = [&](const PlacedBlock& block) { return covers(block.extent, box); };
  const auto first = std::find_if(blocks.begin(), blocks.end(), whole);
  if (first != blocks.end()) {
    if (blocks.size() == 1) return;
    const PlacedBlock& other = blocks[first == blocks.begin() ? 1 : 0];
    throw InputError(fmt::format("{} and {} overlap", text_of(*first), text_of(other)),
                     "every voxel belongs to one block; leave out ghosts");
  }
  const auto [axis, at] = cut_of(box, blocks);
  VoxelBox low = box, high = box;
  low.end[axis] = high.first[axis] = at;
  for (const VoxelBox& part : {low, high}) {
    Blocks meeting;
    std::copy_if(blocks.begin(), blocks.end(), std::back_inserter(meeting),
                 [&](const PlacedBlock& block) { return meet(block.extent, part); });
    check_cover(part, meeting);
  }
}

void deal_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, std::map<int, SliceStore>& stores,
                 std::size_t round_bytes, const Sharing& sharing) {
  BlockDealer{grid, mine, stores, round_bytes, sharing}.run();
}

}  // namespace ringsplat

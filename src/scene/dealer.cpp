#include "scene/dealer.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "classify/normals.hpp"
#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "volume/clipped.hpp"

namespace ringsplat {
namespace {

/// State of one deal, shared by its rounds.
class Dealer {
 public:
  Dealer(const Grid& grid, SliceSupply& supply, const Deal& deal)
      : grid_(grid),
        supply_(supply),
        deal_(deal),
        sharing_(deal.sharing),
        slice_bytes_(grid.slice_bytes(Axis::z)),
        lit_(deal.options.clip.value_or(whole_box(grid))),
        batch_(batch_of(grid)) {
    for (int gp = 0; gp < sharing_.dealing.gps; ++gp)
      if (sharing_.hosts(gp)) stores_.emplace(gp, new_store(gp)).first->second.know_normals_within(lit_);
  }

  std::map<int, SliceStore> run() {
    for (int z = 0; z < grid_.dims.z;) {
      const int end = std::min({grid_.dims.z, z + batch_, supply_.available_from(z)});
      supply_.hand_out(std::max(0, z - 1), std::min(grid_.dims.z, end + 1),
                       [&](int process, int slice) { return needed_by(process, slice, z, end); });
      exchange(z, end);
      if (deal_.dealt) deal_.dealt(end);
      z = end;
    }
    return std::move(stores_);
  }

 private:
  SliceStore new_store(int gp) const {
    const SliceStore* known = nullptr;
    if (deal_.known != nullptr) known = &deal_.known->at(gp);
    return {grid_, gp, sharing_.dealing, deal_.options.kept_axes, deal_.options.with_normals, known};
  }

  bool needed_by(int process, int z, int z0, int z1) const {
    const int reach = deal_.options.with_normals ? 1 : 0;
    for (int owner_z = std::max(z0, z - reach); owner_z <= std::min(z1 - 1, z + reach); ++owner_z)
      if (sharing_.process_of_slice(owner_z) == process) return true;
    return false;
  }

  const std::byte* slice_at(int z) { return z < 0 || z >= grid_.dims.z ? nullptr : supply_.slice(z); }

  /// Owners of z slices [z0, z1) keep them and send every GP its lines of the other two axes.
  void exchange(int z0, int z1) {
    std::vector<Block> out(std::size_t(sharing_.collectives.processes()));
    agree_after(sharing_.collectives, [&] {
      for (int z = z0; z < z1; ++z)
        if (sharing_.hosts(sharing_.dealing.owner_of(z))) send_slice(z, out);
    });
    for (const auto& block : sharing_.collectives.all_to_all(std::move(out))) place_lines(block);
  }

  void send_slice(int z, std::vector<Block>& out) {
    const std::byte* here = slice_at(z);
    std::vector<std::uint16_t> normals;
    if (deal_.options.with_normals) {
      normals.assign(grid_.slice_voxels(Axis::z), no_normal);
      if (lit_ == whole_box(grid_))
        slice_normals(grid_, slice_at(z - 1), here, slice_at(z + 1), normals);
      else if (z >= lit_.first.z && z < lit_.end.z)
        make_normals_within(z, normals);
    }
    const std::span<const std::byte> values(here, slice_bytes_);
    if (deal_.options.kept_axes[2]) {
      SliceStore& store = stores_.at(sharing_.dealing.owner_of(z));
      // They may be what is dealt already.
      if (std::byte* there = store.values(Axis::z, z).data(); there != here)
        std::memcpy(there, here, slice_bytes_);
      std::copy(normals.begin(), normals.end(), store.normals(Axis::z, z).begin());
    }
    for (const Axis axis : {Axis::x, Axis::y}) {
      if (!deal_.options.kept_axes[std::size_t(axis)]) continue;
      for (int gp = 0; gp < sharing_.dealing.gps; ++gp) {
        std::vector<std::byte> lines;
        pack_columns(grid_, axis, gp, sharing_.dealing, values, normals, lines);
        Block& block = out[std::size_t(sharing_.process_of_gp[std::size_t(gp)])];
        append(block, z);
        append(block, axis);
        append(block, gp);
        append(block, std::uint64_t(lines.size()));
        block.insert(block.end(), lines.begin(), lines.end());
      }
    }
  }

  /// The normals of a slice of the volume cropped to lit_, at their places in the whole slice.
  void make_normals_within(int z, std::vector<NormalCode>& normals) {
    const Grid part = clipped_grid(grid_, lit_);
    std::array<Block, 3> slices;
    for (int k = 0; k < 3; ++k) {
      const int at = z + k - 1;
      if (at < lit_.first.z || at >= lit_.end.z) continue;
      slices[std::size_t(k)].resize(part.slice_bytes(Axis::z));
      copy_clipped(grid_, lit_, slice_at(at), slices[std::size_t(k)].data());
    }
    const auto values = [&](std::size_t k) { return slices[k].empty() ? nullptr : slices[k].data(); };
    std::vector<NormalCode> within(part.slice_voxels(Axis::z));
    slice_normals(part, values(0), values(1), values(2), within);
    const auto width = std::ptrdiff_t(part.dims.x);
    for (int y = 0; y < part.dims.y; ++y)
      std::copy_n(within.begin() + y * width, width,
                  normals.begin() + std::ptrdiff_t(lit_.first.y + y) * grid_.dims.x + lit_.first.x);
  }

  void place_lines(std::span<const std::byte> block) {
    for (std::size_t at = 0; at < block.size();) {
      const int z = next_value<int>(block, at);
      const Axis axis = next_value<Axis>(block, at);
      SliceStore& store = stores_.at(next_value<int>(block, at));
      const auto size = next_value<std::uint64_t>(block, at);
      store.unpack_columns(axis, z, next_bytes(block, at, size));
    }
  }

  const Grid& grid_;
  SliceSupply& supply_;
  const Deal& deal_;
  const Sharing& sharing_;
  std::size_t slice_bytes_;
  VoxelBox lit_;  ///< where normals are made
  std::map<int, SliceStore> stores_;
  int batch_;  ///< slices of a round
};

}  // namespace

std::map<int, SliceStore> deal_slices(const Grid& grid, SliceSupply& supply, const Deal& deal) {
  return Dealer(grid, supply, deal).run();
}

}  // namespace ringsplat

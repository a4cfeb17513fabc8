#include "scene/dealer.hpp"

#include <cstring>

#include "classify/normals.hpp"
#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "volume/clipped.hpp"

namespace ringsplat {
namespace {

/// Begins the lines of a z slice in slices of another axis.
struct Lines {
  int z, gp;
  Axis axis;
  std::uint64_t bytes;
};

/// One deal, in rounds.
struct Dealer {
  const Grid& grid;
  SliceSupply& supply;
  const Deal& deal;
  const Sharing& sharing = deal.sharing;
  std::size_t slice_bytes = grid.slice_bytes(Axis::z);
  VoxelBox lit = deal.options.clip.value_or(whole_box(grid));  ///< where normals are made
  std::map<int, SliceStore> stores = {};

  std::map<int, SliceStore> run() {
    for (int gp = 0; gp < sharing.dealing.gps; ++gp) {
      if (!sharing.hosts(gp)) continue;
      const SliceStore* known = deal.known != nullptr ? &deal.known->at(gp) : nullptr;
      const LoadOptions& o = deal.options;
      stores.emplace(gp, SliceStore(grid, gp, sharing.dealing, o.kept_axes, o.with_normals, known));
      stores.at(gp).know_normals_within(lit);
    }
    const int batch = batch_of(grid);
    for (int z = 0; z < grid.dims.z;) {
      const int end = std::min({grid.dims.z, z + batch, supply.available_from(z)});
      supply.hand_out(std::max(0, z - 1), std::min(grid.dims.z, end + 1),
                      [&](int process, int slice) { return needed_by(process, slice, z, end); });
      exchange(z, end);
      if (deal.dealt) deal.dealt(end);
      z = end;
    }
    return std::move(stores);
  }

  bool needed_by(int process, int z, int z0, int z1) const {
    const int reach = deal.options.with_normals ? 1 : 0;
    for (int owner_z = std::max(z0, z - reach); owner_z <= std::min(z1 - 1, z + reach); ++owner_z)
      if (sharing.process_of_slice(owner_z) == process) return true;
    return false;
  }

  const std::byte* slice_at(int z) { return z < 0 || z >= grid.dims.z ? nullptr : supply.slice(z); }

  /// Owners of z slices [z0, z1) keep them and send every GP its lines of the other two axes.
  void exchange(int z0, int z1) {
    std::vector<Block> out(std::size_t(sharing.collectives.processes()));
    agree_after(sharing.collectives, [&] {
      for (int z = z0; z < z1; ++z)
        if (sharing.hosts(sharing.dealing.owner_of(z))) send_slice(z, out);
    });
    for (const Block& block : sharing.collectives.all_to_all(std::move(out)))
      for (std::size_t at = 0; at < block.size();) {
        const auto head = next_value<Lines>(block, at);
        stores.at(head.gp).unpack_columns(head.axis, head.z, next_bytes(block, at, head.bytes));
      }
  }

  void send_slice(int z, std::vector<Block>& out) {
    const std::byte* here = slice_at(z);
    std::vector<std::uint16_t> normals;
    if (deal.options.with_normals) {
      normals.assign(grid.slice_voxels(Axis::z), no_normal);
      if (lit == whole_box(grid))
        slice_normals(grid, slice_at(z - 1), here, slice_at(z + 1), normals);
      else if (z >= lit.first.z && z < lit.end.z)
        make_normals_within(z, normals);
    }
    const std::span<const std::byte> values(here, slice_bytes);
    if (deal.options.kept_axes[2]) {
      SliceStore& store = stores.at(sharing.dealing.owner_of(z));
      // They may be what is dealt already.
      if (std::byte* there = store.values(Axis::z, z).data(); there != here)
        std::memcpy(there, here, slice_bytes);
      std::copy(normals.begin(), normals.end(), store.normals(Axis::z, z).begin());
    }
    for (const Axis axis : {Axis::x, Axis::y}) {
      if (!deal.options.kept_axes[std::size_t(axis)]) continue;
      for (int gp = 0; gp < sharing.dealing.gps; ++gp) {
        std::vector<std::byte> lines;
        pack_columns(grid, axis, gp, sharing.dealing, values, normals, lines);
        Block& block = out[std::size_t(sharing.process_of_gp[std::size_t(gp)])];
        append(block, Lines{z, gp, axis, lines.size()});
        block.insert(block.end(), lines.begin(), lines.end());
      }
    }
  }

  /// The normals of a slice of the volume cropped to lit, at their places in the whole slice.
  void make_normals_within(int z, std::vector<NormalCode>& normals) {
    const Grid part = clipped_grid(grid, lit);
    std::array<Block, 3> slices;
    for (int k = 0; k < 3; ++k) {
      const int at = z + k - 1;
      if (at < lit.first.z || at >= lit.end.z) continue;
      slices[std::size_t(k)].resize(part.slice_bytes(Axis::z));
      copy_clipped(grid, lit, slice_at(at), slices[std::size_t(k)].data());
    }
    const auto values = [&](std::size_t k) { return slices[k].empty() ? nullptr : slices[k].data(); };
    std::vector<NormalCode> within(part.slice_voxels(Axis::z));
    slice_normals(part, values(0), values(1), values(2), within);
    const auto width = std::ptrdiff_t(part.dims.x);
    for (int y = 0; y < part.dims.y; ++y)
      std::copy_n(within.begin() + y * width, width,
                  normals.begin() + std::ptrdiff_t(lit.first.y + y) * grid.dims.x + lit.first.x);
  }
};

}  // namespace

std::map<int, SliceStore> deal_slices(const Grid& grid, SliceSupply& supply, const Deal& deal) {
  return Dealer{grid, supply, deal}.run();
}

}  // namespace ringsplat

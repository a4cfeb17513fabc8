#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "base/byte_stream.hpp"
#include "net/blocks.hpp"
#include "scene/load.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

constexpr int reach = 2;  ///< slices to either side

struct Head {
  Axis axis;
  int slice, gp;
  std::uint64_t bytes;
};

/// Gives the ranges of an owned slice to every GP that owns one near it: here at once, elsewhere by `out`.
void give_around(std::map<int, SliceStore>& stores, const Grid& grid, Axis axis, int slice,
                 SliceDealing dealing, const std::vector<int>& process_of_gp, int here,
                 std::vector<Block>& out) {
  const SliceStore& owner = stores.at(dealing.owner_of(slice));
  const auto ranges = std::make_shared<const CellRanges>(owner.slice(axis, slice));
  std::vector<int> told;
  for (int other = slice - reach; other <= slice + reach; ++other) {
    if (other < 0 || other >= grid.slices(axis)) continue;
    const int gp = dealing.owner_of(other);
    if (std::find(told.begin(), told.end(), gp) != told.end()) continue;
    told.push_back(gp);
    const int process = process_of_gp[std::size_t(gp)];
    if (process == here) {
      stores.at(gp).know_cell_ranges(axis, slice, ranges);
      continue;
    }
    Block& block = out[std::size_t(process)];
    append(block, Head{axis, slice, gp, ranges->bytes().size()});
    block.insert(block.end(), ranges->bytes().begin(), ranges->bytes().end());
  }
}

void take_given(std::span<const std::byte> in, Axis axis, std::map<int, SliceStore>& stores) {
  for (std::size_t at = 0; at < in.size();) {
    Head head{};
    const bool whole = take(in, at, head) && head.bytes <= in.size() - at;
    const auto store = stores.find(head.gp);
    if (!whole || head.axis != axis || store == stores.end() || head.slice < 0 ||
        head.slice >= store->second.grid().slices(axis))
      throw RunError("a rank sent ranges of cells that fit no slice", "all ranks must run the same build");
    const Grid& grid = store->second.grid();
    store->second.know_cell_ranges(
        axis, head.slice,
        std::make_shared<const CellRanges>(grid.type, grid.slice_width(axis), grid.slice_height(axis),
                                           in.subspan(at, head.bytes)));
    at += head.bytes;
  }
}

}  // namespace

void share_cell_ranges(std::map<int, SliceStore>& stores, SliceDealing dealing,
                       const std::vector<std::vector<int>>& gps_of_process, Collectives& collectives) {
  const std::vector<int> process_of_gp = processes_of_gps(dealing, gps_of_process);
  for (const Axis axis : all_axes) {
    std::vector<Block> out(std::size_t(collectives.processes()));
    for (auto& [gp, store] : stores)
      for (int s = 0; store.keeps(axis) && s < store.grid().slices(axis); ++s)
        if (store.owns(s))
          give_around(stores, store.grid(), axis, s, dealing, process_of_gp, collectives.process(), out);
    for (const Block& block : collectives.all_to_all(std::move(out))) take_given(block, axis, stores);
  }
}

}  // namespace ringsplat

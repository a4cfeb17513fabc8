#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <vector>

#include "net/blocks.hpp"
#include "scene/scene.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

/// Calls f(store, slice) for each slice of a kept axis that this process has.
template <class F>
void for_each_owned(const std::map<int, SliceStore>& stores, Axis axis, const F& f) {
  for (const auto& [gp, store] : stores)
    for (int s = 0; store.keeps(axis) && s < store.grid().slices(axis); ++s)
      if (store.owns(s)) f(store, s);
}

constexpr int reach = 2;  ///< slices to either side

struct Head {
  int slice, gp;
  std::uint64_t bytes;
};

/// Gives the ranges of an owned slice to every GP that owns one near it: here at once, elsewhere by `out`.
void give_around(std::map<int, SliceStore>& stores, const SliceStore& owner, Axis axis, int slice,
                 const Sharing& sharing, std::vector<Block>& out) {
  const auto ranges = std::make_shared<const CellRanges>(owner.slice(axis, slice));
  std::vector<int> told;
  for (int other = slice - reach; other <= slice + reach; ++other) {
    if (other < 0 || other >= owner.grid().slices(axis)) continue;
    const int gp = sharing.dealing.owner_of(other);
    if (std::find(told.begin(), told.end(), gp) != told.end()) continue;
    told.push_back(gp);
    if (sharing.hosts(gp)) {
      stores.at(gp).know_cell_ranges(axis, slice, ranges);
      continue;
    }
    Block& block = out[std::size_t(sharing.process_of_gp[std::size_t(gp)])];
    append(block, Head{slice, gp, ranges->bytes().size()});
    block.insert(block.end(), ranges->bytes().begin(), ranges->bytes().end());
  }
}

void merge_heads(ValueTally& tally, Collectives& collectives) {
  const Block mine = to_bytes(tally.range, tally.fill, tally.distinct.overflown());
  tally.range = {};
  tally.fill = 0;
  for (const Block& block : collectives.all_gather(mine)) {
    ValueRange range;
    std::uint64_t fill = 0;
    bool overflown = false;
    read_block(block, "the range of its values", range, fill, overflown);
    tally.range.merge(range);
    tally.fill += fill;
    if (overflown) tally.distinct.overflow();
  }
}

/// All know whether one has overflown.
void merge_distinct(DistinctValues& distinct, Collectives& collectives) {
  if (distinct.overflown()) return;
  using Values = std::vector<double>;
  for (const Block& block : to_process_0(collectives, to_bytes(distinct.sorted())))
    for (const double value : value_of<Values>(block, "its different values")) distinct.add(value);
  bool overflown = false;
  Values all;
  read_block(collectives.broadcast(to_bytes(distinct.overflown(), distinct.sorted()), 0),
             "all different values", overflown, all);
  if (overflown) distinct.overflow();
  for (const double value : all) distinct.add(value);
}

}  // namespace

std::vector<float> points_of(const VolumeSketch& sketch, const SliceView& slice) {
  const auto [u, v] = in_plane(slice.axis);
  std::vector<float> points;
  visit_type(slice.type, [&](auto zero) {
    for (int row = 0; row < sketch.points[v]; ++row)
      for (int column = 0; column < sketch.points[u]; ++column) {
        auto value = zero;
        const auto at = std::size_t(sketch.voxel(u, column)) * sizeof value;
        std::memcpy(&value, slice.values_of_row(sketch.voxel(v, row)) + at, sizeof value);
        points.push_back(static_cast<float>(value));
      }
  });
  return points;
}

std::shared_ptr<const VolumeSketch> share_sketch(const std::map<int, SliceStore>& stores, const Grid& grid,
                                                 Axis axis, Collectives& collectives) {
  auto sketch = std::make_shared<VolumeSketch>(grid.dims);
  // One process has a point, so that its bits and the others' zeros add up to them.
  std::vector<std::uint64_t> bits(sketch->values.size());
  const auto [u, v] = in_plane(axis);
  glm::ivec3 point(0);
  int& layer = point[static_cast<int>(axis)];
  for (; layer < sketch->points[static_cast<int>(axis)]; ++layer) {
    const int slice = sketch->voxel(static_cast<int>(axis), layer);
    for (const auto& [gp, store] : stores) {
      if (!store.owns(slice)) continue;
      const std::vector<float> points = points_of(*sketch, store.slice(axis, slice));
      auto value = points.begin();
      for (point[v] = 0; point[v] < sketch->points[v]; ++point[v])
        for (point[u] = 0; point[u] < sketch->points[u]; ++point[u])
          bits[sketch->index(point)] = std::bit_cast<std::uint32_t>(*value++);
    }
  }
  collectives.sum(bits);
  std::transform(bits.begin(), bits.end(), sketch->values.begin(),
                 [](std::uint64_t of_point) { return std::bit_cast<float>(std::uint32_t(of_point)); });
  return sketch;
}

void share_cell_ranges(std::map<int, SliceStore>& stores, const Sharing& sharing) {
  for (const Axis axis : all_axes) {
    std::vector<Block> out(std::size_t(sharing.collectives.processes()));
    for_each_owned(stores, axis, [&](const SliceStore& owner, int s) {
      give_around(stores, owner, axis, s, sharing, out);
    });
    for (const Block& in : sharing.collectives.all_to_all(std::move(out)))
      for (std::size_t at = 0; at < in.size();) {
        const auto head = next_value<Head>(in, at);
        SliceStore& store = stores.at(head.gp);
        const Grid& grid = store.grid();
        store.know_cell_ranges(
            axis, head.slice,
            std::make_shared<const CellRanges>(grid.type, grid.slice_width(axis), grid.slice_height(axis),
                                               next_bytes(in, at, head.bytes)));
      }
  }
}

void share_slice_ranges(std::map<int, SliceStore>& stores, Collectives& collectives) {
  std::vector<SliceRange> mine;
  for (const Axis axis : all_axes)
    for_each_owned(stores, axis, [&](const SliceStore& store, int s) {
      mine.push_back(slice_range(store.slice(axis, s)));
    });
  const auto ranges = std::make_shared<SliceRanges>();
  for (const Block& one : collectives.all_gather(to_bytes(mine)))
    for (const SliceRange& range : value_of<std::vector<SliceRange>>(one, "its slices' ranges"))
      (*ranges)[std::size_t(range.axis)].push_back(range);
  for (auto& of_axis : *ranges) std::ranges::sort(of_axis, {}, &SliceRange::slice);
  for (auto& [gp, store] : stores) store.know_ranges(ranges);
}

ValueStatistics share_values(const std::map<int, SliceStore>& stores, const Grid& grid,
                             const VolumeNotes& notes, Collectives& collectives) {
  // The slices of one kept axis have each voxel once over all processes.
  const auto kept = std::find_if(all_axes.rbegin(), all_axes.rend(), [&](Axis axis) {
    return !stores.empty() && stores.begin()->second.keeps(axis);
  });
  const Pass pass = [&](const RowVisitor& visit) {
    if (kept == all_axes.rend()) return;
    for_each_owned(stores, *kept, [&](const SliceStore& store, int s) {
      visit(std::span(store.slice(*kept, s).values, grid.slice_bytes(*kept)), grid.slice_width(*kept));
    });
  };
  const auto sum = [&](std::vector<std::uint64_t>& counts) { collectives.sum(counts); };
  const auto merge = [&](ValueTally& tally) {
    merge_heads(tally, collectives);
    sum(tally.counts);
    merge_distinct(tally.distinct, collectives);
  };
  return describe_values(grid, notes, pass, {merge, sum});
}

}  // namespace ringsplat

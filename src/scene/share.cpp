#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "net/blocks.hpp"
#include "scene/scene.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

void take_points(std::span<const std::byte> in, Axis axis, VolumeSketch& sketch) {
  const auto [u, v] = in_plane(axis);
  for (std::size_t at = 0; at < in.size();) {
    glm::ivec3 point(0);
    point[static_cast<int>(axis)] = next_value<int>(in, at);
    for (point[v] = 0; point[v] < sketch.points[v]; ++point[v])
      for (point[u] = 0; point[u] < sketch.points[u]; ++point[u])
        sketch.values[sketch.index(point)] = next_value<float>(in, at);
  }
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
  Block mine;
  for (int layer = 0; layer < sketch->points[static_cast<int>(axis)]; ++layer) {
    const int slice = sketch->voxel(static_cast<int>(axis), layer);
    for (const auto& [gp, store] : stores) {
      if (!store.owns(slice)) continue;
      append(mine, layer);
      for (const float point : points_of(*sketch, store.slice(axis, slice))) append(mine, point);
    }
  }
  // By way of process 0: blocks from each to each would be too many with a thousand processes.
  for (const Block& block : to_process_0(collectives, std::move(mine))) take_points(block, axis, *sketch);
  const Block all = collectives.broadcast(block_of(std::as_bytes(std::span(sketch->values))), 0);
  std::memcpy(sketch->values.data(), all.data(), all.size());
  return sketch;
}

namespace {

constexpr int reach = 2;  ///< slices to either side

struct Head {
  int slice, gp;
  std::uint64_t bytes;
};

/// Gives the ranges of an owned slice to every GP that owns one near it: here at once, elsewhere by `out`.
void give_around(std::map<int, SliceStore>& stores, const Grid& grid, Axis axis, int slice,
                 const Sharing& sharing, std::vector<Block>& out) {
  const SliceStore& owner = stores.at(sharing.dealing.owner_of(slice));
  const auto ranges = std::make_shared<const CellRanges>(owner.slice(axis, slice));
  std::vector<int> told;
  for (int other = slice - reach; other <= slice + reach; ++other) {
    if (other < 0 || other >= grid.slices(axis)) continue;
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

void take_given(std::span<const std::byte> in, Axis axis, std::map<int, SliceStore>& stores) {
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

}  // namespace

void share_cell_ranges(std::map<int, SliceStore>& stores, const Sharing& sharing) {
  for (const Axis axis : all_axes) {
    std::vector<Block> out(std::size_t(sharing.collectives.processes()));
    for (auto& [gp, store] : stores)
      for (int s = 0; store.keeps(axis) && s < store.grid().slices(axis); ++s)
        if (store.owns(s)) give_around(stores, store.grid(), axis, s, sharing, out);
    for (const Block& block : sharing.collectives.all_to_all(std::move(out))) take_given(block, axis, stores);
  }
}

void share_slice_ranges(std::map<int, SliceStore>& stores, Collectives& collectives) {
  std::vector<SliceRange> mine;
  for (const auto& [gp, store] : stores)
    for (const Axis axis : all_axes)
      for (int s = 0; store.keeps(axis) && s < store.grid().slices(axis); ++s)
        if (store.owns(s)) mine.push_back(slice_range(store.slice(axis, s)));
  std::vector<SliceRange> all;
  for (const auto& one : collectives.all_gather(block_of(std::as_bytes(std::span(mine)))))
    for (std::size_t at = 0; at < one.size();) all.push_back(next_value<SliceRange>(one, at));
  const auto ranges = std::make_shared<const SliceRanges>(all);
  for (auto& [gp, store] : stores) store.know_ranges(ranges);
}

namespace {

template <class T>
std::vector<T> values_of(const Block& block) {
  std::vector<T> values(block.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), block.data(), block.size());
  return values;
}

/// Sums over all processes. One process adds them up: with a thousand processes, each could not hold the
/// counts of all.
void sum_up(Collectives& collectives, std::span<std::uint64_t> mine) {
  Block sums = block_of(std::as_bytes(mine));
  const auto in = to_process_0(collectives, sums);
  if (collectives.process() == 0) {
    std::fill(mine.begin(), mine.end(), 0);
    for (const Block& one : in) {
      const auto counts = values_of<std::uint64_t>(one);
      for (std::size_t k = 0; k < mine.size(); ++k) mine[k] += counts[k];
    }
    sums = block_of(std::as_bytes(mine));
  }
  sums = collectives.broadcast(std::move(sums), 0);
  if (!mine.empty()) std::memcpy(mine.data(), sums.data(), sums.size());
}

class MergingAll final : public Merging {
 public:
  explicit MergingAll(Collectives& collectives) : collectives_(collectives) {}

  void merge(ValueTally& tally) override {
    merge_heads(tally);
    // Keys outside the common range are empty. In parts, so that process 0 holds a part of all at once.
    if (!tally.range.empty()) {
      const auto type = tally.kind().type;
      const auto first = ValueTally::key_of(type, tally.range.low);
      const auto end = ValueTally::key_of(type, tally.range.high) + 1;
      constexpr std::size_t part = 4096;
      for (std::size_t at = first; at < end; at += part)
        sum_up(collectives_, std::span(tally.counts).subspan(at, std::min(part, end - at)));
    }
    merge_distinct(tally.distinct);
  }

  void sum(std::vector<std::uint64_t>& counts) override { sum_up(collectives_, counts); }

 private:
  struct Head {
    ValueRange range;
    std::uint64_t fill;
    std::uint64_t overflown;
  };

  void merge_heads(ValueTally& tally) {
    const Head mine{tally.range, tally.fill, tally.distinct.overflown()};
    tally.range = {};
    tally.fill = 0;
    for (const Block& block : collectives_.all_gather(block_of_value(mine))) {
      const Head one = value_of<Head>(block, "the range of its values");
      tally.range.merge(one.range);
      tally.fill += one.fill;
      if (one.overflown != 0) tally.distinct.overflow();
    }
  }

  /// All know whether one has overflown.
  void merge_distinct(DistinctValues& distinct) {
    if (distinct.overflown()) return;
    const auto mine = distinct.sorted();
    const auto in = to_process_0(collectives_, block_of(std::as_bytes(std::span(mine))));
    if (collectives_.process() == 0)
      for (const Block& one : in) distinct.merge(values_of<double>(one));
    // More than a process may have are sent as one too many.
    std::vector<double> all = distinct.sorted();
    if (distinct.overflown()) all.assign(DistinctValues::most + 1, 0.0);
    const Block block = collectives_.broadcast(block_of(std::as_bytes(std::span(all))), 0);
    all = values_of<double>(block);
    if (all.size() > DistinctValues::most)
      distinct.overflow();
    else
      distinct.merge(all);
  }

  Collectives& collectives_;
};

/// Calls `f(values, width of a row)` for every slice of one kept axis of every store: each voxel once over
/// all processes.
void for_each_slice(const std::map<int, SliceStore>& stores, const RowVisitor& f) {
  for (const auto& [gp, store] : stores) {
    const auto kept =
        std::find_if(all_axes.rbegin(), all_axes.rend(), [&](Axis a) { return store.keeps(a); });
    for (int s = 0; kept != all_axes.rend() && s < store.grid().slices(*kept); ++s)
      if (store.owns(s))
        f(std::span(store.slice(*kept, s).values, store.grid().slice_bytes(*kept)),
          store.grid().slice_width(*kept));
  }
}

}  // namespace

ValueStatistics share_values(const std::map<int, SliceStore>& stores, const Grid& grid,
                             const VolumeNotes& notes, Collectives& collectives) {
  MergingAll merging(collectives);
  const ValueKind kind{grid.type, notes.fill};
  const Pass pass = [&](const RowVisitor& f) { for_each_slice(stores, f); };
  return describe_values(kind, grid.dims, notes, pass, merging);
}

}  // namespace ringsplat

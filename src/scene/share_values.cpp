#include <algorithm>
#include <cstring>

#include "net/blocks.hpp"
#include "scene/scene.hpp"

namespace ringsplat {
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

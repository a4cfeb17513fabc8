#include "volume/value_statistics.hpp"

#include <cstdlib>
#include <numeric>

#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

constexpr int histogram_bins = 1024;
/// Up to `few_labels` are labels even where neighbours are the next ones, as in nested parts.
constexpr std::size_t most_found_labels = 256, few_labels = 16;
/// Voxels whose neighbours are counted, about: of more one row in so many.
constexpr double most_looked_at = 1 << 21;

/// The keys' bins within the range. A key that begins with the largest value has a bin of the smallest width
/// there is, as a bin does not hold its upper bound.
Bins bins_of_keys(const ValueTally& tally) {
  Bins bins;
  const auto type = tally.kind().type;
  const auto& range = tally.range;
  for (std::size_t key = 0; key < tally.counts.size(); ++key) {
    if (tally.counts[key] == 0) continue;
    const auto edges = ValueTally::edges_of(type, key);
    const double low = std::clamp(edges.low, range.low, range.high);
    double high = std::clamp(edges.high, range.low, range.high);
    if (!ValueTally::is_exact(type))
      high = std::max(high, std::nextafter(low, std::numeric_limits<double>::max()));
    bins.push_back({low, high, tally.counts[key]});
  }
  return bins;
}

/// Voxels below each of `edges`, ascending, as the bins tell it exactly; `edges` hold all their bounds.
std::vector<double> counted_below(const Bins& bins, const std::vector<double>& edges) {
  std::vector<double> below;
  double sum = 0;
  std::size_t k = 0;
  for (const double edge : edges) {
    while (k < bins.size() && bins[k].high <= edge && bins[k].low < edge) sum += double(bins[k++].count);
    double here = sum;
    if (k < bins.size() && bins[k].low < edge)
      here += double(bins[k].count) * (edge - bins[k].low) / (bins[k].high - bins[k].low);
    below.push_back(here);
  }
  return below;
}

/// Both divisions of the values in one: at every edge the count below it is exact in one of them, the one
/// whose edge it is.
Bins refined(const Bins& keys, const Bins& equal) {
  std::vector<double> edges;
  for (const auto* bins : {&keys, &equal})
    for (const ValueBin& bin : *bins) edges.insert(edges.end(), {bin.low, bin.high});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  const auto by_keys = counted_below(keys, edges), by_equal = counted_below(equal, edges);
  const auto is_edge = [](const Bins& bins, double edge) {
    const auto at = std::ranges::lower_bound(bins, edge, {}, &ValueBin::low);
    return (at != bins.end() && at->low == edge) || (at != bins.begin() && (at - 1)->high == edge);
  };
  Bins bins;
  double before = 0;
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const double below = std::max(before, is_edge(keys, edges[i]) ? by_keys[i] : by_equal[i]);
    const auto count = std::uint64_t(std::llround(below) - std::llround(before));
    if (count > 0) bins.push_back({edges[i - 1], edges[i], count});
    before = below;
  }
  return bins;
}

Bins bins_of(const Histogram& h) {
  Bins bins;
  const double count = double(h.counts.size());
  for (std::size_t k = 0; k < h.counts.size(); ++k)
    if (h.counts[k] > 0)
      bins.push_back({std::lerp(h.low, h.high, double(k) / count),
                      std::lerp(h.low, h.high, double(k + 1) / count), h.counts[k]});
  return bins;
}

void count_histogram(ValueStatistics& s, const Bins& keys, const Pass& pass, const Merging& merging) {
  const KeptBins kept = without_outliers(keys);
  s.histogram = Histogram(keys[kept.first].low, std::min(keys[kept.last].high, s.range.high), histogram_bins);
  const ScalarType type = s.grid.type;
  const bool exact = ValueTally::is_exact(type);
  if (exact) {
    for (std::size_t k = kept.first; k <= kept.last; ++k) s.histogram.add(keys[k].low, keys[k].count);
  } else {
    pass([&](std::span<const std::byte> rows, int) {
      for_each_unfilled({type, s.notes.fill}, rows, [&](auto values) { s.histogram.add(type, values); });
    });
    merging.sum(s.histogram.counts);
  }
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (k < kept.first) s.histogram.below += keys[k].count;
    if (k > kept.last) s.histogram.above += keys[k].count;
  }
  s.bins = keys;
  if (exact) return;
  s.bins = refined({keys.begin() + std::ptrdiff_t(kept.first), keys.begin() + std::ptrdiff_t(kept.last) + 1},
                   bins_of(s.histogram));
  s.bins.insert(s.bins.begin(), keys.begin(), keys.begin() + std::ptrdiff_t(kept.first));
  s.bins.insert(s.bins.end(), keys.begin() + std::ptrdiff_t(kept.last) + 1, keys.end());
}

/// Adds to the numbers of NeighbourCounts. `place_of`: a value's place among the labels, below 0 for others.
template <class T, class PlaceOf>
void count_row(std::span<const T> row, const PlaceOf& place_of, std::vector<std::uint64_t>& counts) {
  std::ptrdiff_t before = -1;
  bool changed = false;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const auto here = i > 0 && row[i] == row[i - 1] ? before : place_of(double(row[i]));
    if (here >= 0 && before >= 0) ++counts[here == before ? 0 : std::abs(here - before) == 1 ? 1 : 2];
    const bool changes = i > 0 && here != before;
    if (changes && changed) ++counts[3];
    changed = changes;
    before = here;
  }
}

void count_neighbours(ValueStatistics& s, const Pass& pass, const Merging& merging) {
  const auto place_of = [&labels = s.labels](double value) -> std::ptrdiff_t {
    const auto at = std::ranges::lower_bound(labels, value);
    return at != labels.end() && *at == value ? at - labels.begin() : -1;
  };
  std::vector<std::uint64_t> counts(4);
  const auto one_in = std::size_t(std::max(1.0, double(s.grid.voxels()) / most_looked_at));
  pass([&](std::span<const std::byte> rows, int width) {
    for_values(s.grid.type, rows, [&](auto values) {
      for (std::size_t row = 0; (row + 1) * std::size_t(width) <= values.size(); row += one_in)
        count_row(values.subspan(row * std::size_t(width), std::size_t(width)), place_of, counts);
    });
  });
  merging.sum(counts);
  s.neighbours = {counts[0], counts[1], counts[2], counts[3]};
}

/// A mask, or few values of which 0 is the most frequent.
bool few_about_zero(const ValueStatistics& s) {
  if (s.labels.front() != 0 || s.labels.size() > few_labels) return false;
  const auto most = std::ranges::max_element(s.bins, {}, &ValueBin::count);
  return s.labels.size() == 2 || most->low <= 0;
}

std::vector<double> all_values(const ValueTally& tally, const Bins& keys) {
  if (!ValueTally::is_exact(tally.kind().type)) return tally.distinct.sorted();
  std::vector<double> values;
  for (const ValueBin& bin : keys) values.push_back(bin.low);
  if (values.size() > DistinctValues::most) values.clear();
  return values;
}

}  // namespace

double count_of(const Bins& bins) {
  return std::accumulate(bins.begin(), bins.end(), 0.0,
                         [](double sum, const ValueBin& bin) { return sum + double(bin.count); });
}

double ValueStatistics::coarseness() const {
  return notes.finest ? grid.unit_length() / notes.finest->unit_length() : 1;
}

double ValueStatistics::quantile(double share) const {
  if (bins.empty()) return 0;
  if (share <= 0) return range.low;
  if (share >= 1) return range.high;
  const double wanted = share * count_of(bins);
  double below = 0;
  for (const ValueBin& bin : bins) {
    const double here = double(bin.count);
    if (below + here >= wanted) {
      // The key of 0 holds float32's smallest numbers, too.
      const bool narrow = !(bin.high - bin.low >= double(std::numeric_limits<float>::min()));
      return narrow ? bin.low : std::lerp(bin.low, bin.high, (wanted - below) / here);
    }
    below += here;
  }
  return range.high;
}

void visit_slices(VolumeSource& source, int first, int count, const RowVisitor& visit) {
  constexpr std::size_t batch_bytes = std::size_t{8} << 20;
  const Grid& grid = source.grid();
  const std::size_t slice = grid.slice_bytes(Axis::z);
  const int batch = int(std::clamp<std::size_t>(batch_bytes / slice, 1, std::size_t(count)));
  std::vector<std::byte> voxels(slice * std::size_t(batch));
  for (int z = first; z < first + count; z += batch) {
    const int there = std::min(batch, first + count - z);
    std::span rest(voxels.data(), slice * std::size_t(there));
    source.read_slices(z, there, rest);
    for (; !rest.empty(); rest = rest.subspan(slice)) visit(rest.first(slice), grid.dims.x);
  }
}

ValueStatistics describe_values(const Grid& grid, const VolumeNotes& notes, const Pass& pass,
                                const Merging& merging) {
  ValueStatistics s;
  s.grid = grid;
  s.notes = notes;
  ValueTally tally({grid.type, notes.fill});
  pass([&](std::span<const std::byte> rows, int) { tally.add(rows); });
  merging.merge(tally);
  s.range = tally.range;
  s.fill_voxels = tally.fill;
  s.histogram = Histogram(0, 1, histogram_bins);
  if (s.range.empty()) return s;
  const auto keys = bins_of_keys(tally);
  if (keys.empty()) return s;
  count_histogram(s, keys, pass, merging);
  s.labels = all_values(tally, keys);
  if (s.labels.size() > 1 && s.labels.size() <= most_found_labels) count_neighbours(s, pass, merging);
  return s;
}

ValueStatistics describe_values(const Histogram& histogram) {
  ValueStatistics s;
  s.grid.type = ScalarType::float64;
  s.histogram = histogram;
  s.bins = bins_of(histogram);
  s.range.low = histogram.low;
  s.range.high = histogram.high;
  s.range.finite = histogram.total();
  return s;
}

KeptBins without_outliers(const Bins& bins) {
  constexpr double far = 50;
  const auto few = std::max<std::uint64_t>(1, std::uint64_t(count_of(bins)) / 10000);
  KeptBins core{0, bins.size() - 1};
  std::uint64_t seen = bins.front().count;
  while (seen <= few && core.first < core.last) seen += bins[++core.first].count;
  seen = bins.back().count;
  while (seen <= few && core.first < core.last) seen += bins[--core.last].count;
  if (core.first >= core.last) return {0, bins.size() - 1};
  const double reach = far * (bins[core.last].high - bins[core.first].low);
  KeptBins kept = core;
  while (kept.first > 0 && !(bins[kept.first].low - bins[kept.first - 1].high > reach)) --kept.first;
  while (kept.last + 1 < bins.size() && !(bins[kept.last + 1].low - bins[kept.last].high > reach))
    ++kept.last;
  return kept;
}

bool look_like_labels(const ValueStatistics& s) {
  if (!s.neighbours || s.labels.front() < 0) return false;
  const auto [equal, adjacent, apart, alone] = *s.neighbours;
  const double changes = double(adjacent + apart), pairs = double(equal) + changes;
  if (few_about_zero(s)) return s.labels.size() == 2 || double(alone) <= 0.4 * changes;
  // Scans cut down to few grey levels have either next levels as neighbours (a head of 3 to 8 levels: at most
  // a tenth of the changes are others) or thin lines of the levels between (of 6 and more: a quarter of all
  // pieces and more). Pieces of labels hardly have either.
  return double(equal) >= 0.85 * pairs && double(apart) >= 0.25 * changes && double(alone) <= 0.15 * changes;
}

Histogram coarser(const Histogram& histogram, int bins) {
  Histogram coarse(histogram.low, histogram.high, bins);
  coarse.below = histogram.below;
  coarse.above = histogram.above;
  for (std::size_t k = 0; k < histogram.counts.size(); ++k)
    coarse.counts[k * std::size_t(bins) / histogram.counts.size()] += histogram.counts[k];
  return coarse;
}

}  // namespace ringsplat

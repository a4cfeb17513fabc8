#include "classify/value_shape.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ringsplat {
namespace {

/// True when a bin at one end is far from all others, next of which is `gap` away.
bool is_fill(const ValueBin& end, double gap, double span, double total) {
  static constexpr double usual[] = {-99999, -9999, -999, -32768, -32767, 9999, 99999, 999999, 32767};
  constexpr double huge = 1e19;
  const bool known = std::abs(end.middle()) >= huge ||
                     std::ranges::any_of(usual, [&](double v) { return end.low <= v && v <= end.high; });
  return double(end.count) >= 0.001 * total && gap >= (known ? 0.1 : 2.0) * span;
}

void take_out_fill(Data& d) {
  constexpr std::size_t least = 4;  // the fill value and a few others
  if (d.bins.size() < least) return;
  const double total = count_of(d.bins);
  const auto& b = d.bins;
  const std::size_t last = b.size() - 1;
  if (is_fill(b[0], b[1].low - b[0].high, b[last].high - b[1].low, total)) {
    d.fill_below = b[0].low;
    d.filled += double(b[0].count);
    d.bins.erase(d.bins.begin());
  } else if (is_fill(b[last], b[last].low - b[last - 1].high, b[last - 1].high - b[0].low, total)) {
    d.fill_above = b[last].high;
    d.filled += double(b[last].count);
    d.bins.pop_back();
  }
}

void take_out_outliers(Data& d) {
  const auto [first, last] = without_outliers(d.bins);
  for (std::size_t k = 0; k < d.bins.size(); ++k) {
    if (k >= first && k <= last) continue;
    d.outside += double(d.bins[k].count);
    const double value = k < first ? d.bins[k].low : d.bins[k].high;
    (k < first ? d.outside_below : d.outside_above) = true;
    if (std::abs(value) > std::abs(d.outlier)) d.outlier = value;
  }
  d.bins = Bins(d.bins.begin() + std::ptrdiff_t(first), d.bins.begin() + std::ptrdiff_t(last) + 1);
}

/// Counts in equal bins: peaks are looked for there.
struct Even {
  double low, width;
  std::vector<double> counts;
  double edge(std::size_t k) const { return low + width * double(k); }
};

Even evenly(const Bins& bins) {
  constexpr std::size_t most = 256;
  // No finer than the values are.
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < bins.size(); ++k)
    if (bins[k].low == bins[k].high) smallest = std::min(smallest, bins[k].low - bins[k - 1].low);
  const double low = bins.front().low, span = bins.back().high - low;
  if (!(span > 0) || !std::isfinite(span)) return {low, 0, {count_of(bins)}};
  const double wanted = std::isfinite(smallest) ? span / smallest + 1 : double(most);
  const auto count = std::size_t(std::clamp(wanted, 2.0, double(most)));
  const bool whole = wanted <= double(most) && std::isfinite(smallest);
  Even even{low, whole ? smallest : span / double(count), std::vector<double>(count)};
  for (const ValueBin& bin : bins)
    even.counts[std::min(count - 1, std::size_t((bin.middle() - low) / even.width))] += double(bin.count);
  return even;
}

/// Means over neighbours, where bins are fine.
std::vector<double> smoothed(const std::vector<double>& counts) {
  const std::size_t reach = counts.size() / 64;
  std::vector<double> means;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const std::size_t first = k > reach ? k - reach : 0, end = std::min(counts.size(), k + reach + 1);
    means.push_back(
        std::accumulate(counts.begin() + std::ptrdiff_t(first), counts.begin() + std::ptrdiff_t(end), 0.0) /
        double(end - first));
  }
  return means;
}

/// Where a peak ends: down its slope, over small rises, while counts are still a good part of the peak.
std::size_t foot_of(const std::vector<double>& counts, std::size_t peak, bool upward) {
  constexpr double rise = 1.25;
  const double floor = counts[peak] / 20;
  std::size_t lowest = peak;
  const std::size_t last = upward ? counts.size() - 1 : 0;
  for (std::size_t bin = peak; bin != last;) {
    bin = upward ? bin + 1 : bin - 1;
    if (counts[bin] > rise * counts[lowest] || counts[bin] < floor) break;
    if (counts[bin] < counts[lowest]) lowest = bin;
  }
  return lowest;
}

/// The smallest of two values, or 0 where it is the most frequent of few single values: none of the others
/// may be lost.
bool begins_at_background(const Bins& bins) {
  constexpr std::size_t few = 16;
  if (bins.size() == 2) return true;
  return bins.size() <= few && bins[0].low == 0 && std::ranges::all_of(bins, [&](const ValueBin& bin) {
           return bin.low == bin.high && bin.count <= bins[0].count;
         });
}

/// The middle of the shortest stretch of values that half of the voxels have. The lowest value counts no more
/// than the next one: all below it may have been cut off to it.
double densest_middle(Bins bins) {
  const double half = 0.5 * count_of(bins);
  if (bins.size() > 1) bins[0].count = std::min(bins[0].count, bins[1].count);
  double within = 0, most = 0, shortest = std::numeric_limits<double>::infinity(), middle = bins[0].low;
  for (std::size_t first = 0, last = 0; last < bins.size(); ++last) {
    within += double(bins[last].count);
    for (; within >= half; within -= double(bins[first++].count)) {
      const double width = bins[last].high - bins[first].low;
      if (width > shortest || (width == shortest && within <= most)) continue;
      shortest = width, most = within;
      middle = std::lerp(bins[first].low, bins[last].high, 0.5);
    }
  }
  return middle;
}

/// Where noise about an offset ends, if it is a background: a peak of most voxels whose lower flank, which no
/// object reaches, tells its spread; from its other end on, far more values than noise has.
std::optional<double> end_of_noise(const Data& d) {
  const double middle = densest_middle(d.bins);
  const double below = share_within(d.bins, -std::numeric_limits<double>::infinity(), middle) +
                       0.5 * share_within(d.bins, middle, std::nextafter(middle, d.high() + 1));
  const double spread = middle - upper_quantile(d.bins, 0.3173 * below);  // one standard deviation
  if (!(spread > 0)) return std::nullopt;
  const double end = middle + 3 * spread;
  const auto share = [&](double from, double to) {
    return share_within(d.bins, middle + from * spread, middle + to * spread);
  };
  constexpr double far = std::numeric_limits<double>::infinity();
  const bool peak = share(2.5, 3.5) < 0.2 * share(-0.5, 0.5), alone = share(-far, -4) < 0.01;
  const bool object = d.high() - middle > 1.5 * (middle - d.low()) && share(3, far) > 3 * share(-far, -3);
  if (below < 0.25 || !peak || !alone || !object) return std::nullopt;
  return end;
}

}  // namespace

double upper_quantile(const Bins& bins, double share) {
  const double wanted = share * count_of(bins);
  double seen = 0;
  for (const ValueBin& bin : bins)
    if ((seen += double(bin.count)) >= wanted) return bin.high;
  return bins.empty() ? 0 : bins.back().high;
}

double share_within(const Bins& bins, double low, double high) {
  double sum = 0;
  for (const ValueBin& bin : bins)
    if (bin.middle() >= low && bin.middle() < high) sum += double(bin.count);
  return sum / std::max(1.0, count_of(bins));
}

Data data_of(const ValueStatistics& s) {
  Data d;
  d.bins = s.bins;
  d.all = count_of(d.bins);
  if (s.grid.voxels() > 1) d.depth = std::cbrt(double(s.grid.voxels())) * s.coarseness();
  take_out_outliers(d);
  take_out_fill(d);
  take_out_outliers(d);
  return d;
}

Foreground find_foreground(const Data& d) {
  Foreground all{true, d.bins, d.low(), false};
  const Even even = evenly(d.bins);
  const auto slope = smoothed(even.counts);
  const double total = count_of(d.bins);
  if (begins_at_background(d.bins)) return {true, {d.bins.begin() + 1, d.bins.end()}, d.bins[0].high, true};
  double highest = 0;
  for (std::size_t peak = 0; peak < even.counts.size(); ++peak) {
    const double here = even.counts[peak];
    if (here < total / 10 || here <= highest) continue;
    const std::size_t above = foot_of(slope, peak, true) + 1, below = foot_of(slope, peak, false);
    const double voxels_above =
        std::accumulate(even.counts.begin() + std::ptrdiff_t(above), even.counts.end(), 0.0);
    const double voxels_below =
        std::accumulate(even.counts.begin(), even.counts.begin() + std::ptrdiff_t(below), 0.0);
    const double beyond = std::min(voxels_above, voxels_below);
    if (beyond > 0.05 * total || beyond > 0.5 * std::max(voxels_above, voxels_below)) continue;
    if (voxels_above == 0 && voxels_below == 0) continue;
    highest = here;
    const bool upward = voxels_above >= voxels_below;
    all = {upward, {}, even.edge(upward ? above : below), true};
  }
  if (const auto end = end_of_noise(d); end && all.upward && *end > all.edge) all = {true, {}, *end, true};
  if (!all.background) return all;
  for (const ValueBin& bin : d.bins)
    if (all.upward ? bin.middle() >= all.edge : bin.middle() < all.edge) all.bins.push_back(bin);
  if (all.bins.empty()) return {true, d.bins, d.low(), false};
  return all;
}

std::optional<Plateau> flatten_plateaus(Bins& bins, double all) {
  std::optional<Plateau> found;
  if (bins.size() < 8) return found;
  const double total = count_of(bins);
  const Bins before = bins;
  for (std::size_t k = 0; k < bins.size(); ++k) {
    const double here = double(before[k].count);
    if (here < 0.05 * total) continue;
    double about = 0;
    int others = 0;
    for (std::size_t i = k > 4 ? k - 4 : 0; i < std::min(before.size(), k + 5); ++i)
      if (i != k) about = std::max(about, double(before[i].count)), ++others;
    if (here < 10 * about || others == 0) continue;
    bins[k].count = std::uint64_t(about);
    if (here > 0.1 * all && (!found || here > found->voxels)) found = Plateau{before[k].middle(), here};
  }
  return found;
}

}  // namespace ringsplat

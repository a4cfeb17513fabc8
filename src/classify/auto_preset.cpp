#include "classify/auto_preset.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace ringsplat {
namespace {

constexpr double haze = 0.05;

/// The histogram's bins in order away from its background.
struct Foreground {
  bool upward;             ///< values grow away from the background
  std::size_t first, end;  ///< the foreground's bins, first < end, counted from the low end
  std::uint64_t voxels;
};

std::uint64_t voxels_between(const Histogram& h, std::size_t first, std::size_t end) {
  return std::accumulate(h.counts.begin() + std::ptrdiff_t(first), h.counts.begin() + std::ptrdiff_t(end),
                         std::uint64_t(0));
}

/// Where the background ends: down the peak's slope while counts fall and are still a good part of the peak.
std::size_t foot_of(const Histogram& h, std::size_t peak, bool upward) {
  const auto floor = h.counts[peak] / 20;
  std::size_t bin = peak;
  const auto last = upward ? h.counts.size() - 1 : std::size_t(0);
  while (bin != last) {
    const auto next = upward ? bin + 1 : bin - 1;
    if (h.counts[next] >= h.counts[bin] || h.counts[next] < floor) break;
    bin = next;
  }
  return bin;
}

Foreground find_foreground(const Histogram& h, std::uint64_t total) {
  const auto bins = h.counts.size();
  const auto peak = std::size_t(std::max_element(h.counts.begin(), h.counts.end()) - h.counts.begin());
  const Foreground everything{true, 0, bins, total};
  if (h.counts[peak] < total / 10) return everything;
  const std::size_t above = foot_of(h, peak, true) + 1, below = foot_of(h, peak, false);
  const auto voxels_above = voxels_between(h, above, bins), voxels_below = voxels_between(h, 0, below);
  if (voxels_above == 0 && voxels_below == 0) return everything;
  if (voxels_above >= voxels_below) return {true, above, bins, voxels_above};
  return {false, 0, below, voxels_below};
}

/// The value up to which `share` of the foreground lies, counted from the background: a bin's far edge.
double quantile_edge(const Histogram& h, const DataRange& range, const Foreground& f, double share) {
  const double wanted = share * double(f.voxels), bins = double(h.counts.size());
  double seen = 0;
  for (std::size_t k = 0; k < f.end - f.first; ++k) {
    const std::size_t bin = f.upward ? f.first + k : f.end - 1 - k;
    seen += double(h.counts[bin]);
    if (seen >= wanted) return range.at((f.upward ? double(bin) + 1 : double(bin)) / bins);
  }
  return f.upward ? range.high : range.low;
}

const std::vector<glm::dvec3> warm{
    {0.35, 0.12, 0.10}, {0.78, 0.40, 0.26}, {0.95, 0.76, 0.54}, {1.0, 0.96, 0.88}};

TransferFunction even_haze(const DataRange& range) {
  TransferFunction tf;
  tf.colours = {{range.low, warm[2]}, {range.high, warm[2]}};
  tf.opacities = {{range.low, haze}, {range.high, haze}};
  return tf;
}

}  // namespace

DataRange range_of(const Histogram& histogram) {
  double low = histogram.low, high = histogram.high;
  if (!std::isfinite(low) || !std::isfinite(high) || low > high) return {0.0, 1.0};
  if (low < high) return {low, high};
  constexpr double most = std::numeric_limits<double>::max();
  const double reach = std::max(1.0, std::abs(low));
  return {low > reach - most ? low - reach : -most, high < most - reach ? high + reach : most};
}

TransferFunction auto_preset(const Histogram& histogram) {
  const DataRange range = range_of(histogram);
  const auto total = histogram.counts.empty() ? 0 : voxels_between(histogram, 0, histogram.counts.size());
  TransferFunction tf = even_haze(range);
  if (total > 0 && histogram.low < histogram.high) {
    const Foreground f = find_foreground(histogram, total);
    const double bins = double(histogram.counts.size());
    const double edge = range.at(double(f.upward ? f.first : f.end) / bins);
    const double common = quantile_edge(histogram, range, f, 0.5),
                 rare = quantile_edge(histogram, range, f, 0.9);
    const double extreme = f.upward ? range.high : range.low, behind = f.upward ? range.low : range.high;
    tf.opacities = {{behind, 0.0}, {edge, 0.0}, {common, haze}, {rare, 0.3}, {extreme, 0.7}};
    tf.colours = {{edge, warm[0]}, {common, warm[1]}, {rare, warm[2]}, {extreme, warm[3]}};
    if (!f.upward) {
      std::reverse(tf.opacities.begin(), tf.opacities.end());
      std::reverse(tf.colours.begin(), tf.colours.end());
    }
  }
  tf.name = "auto";
  return tf;
}

}  // namespace ringsplat

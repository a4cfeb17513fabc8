#include "ringsplat/volume/statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>

namespace ringsplat {
namespace {

template <class F>
void for_values(ScalarType type, std::span<const std::byte> bytes, F&& f) {
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    f(std::span(reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)));
  });
}

struct Extremes {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  std::uint64_t finite = 0;
};

template <class T>
Extremes extremes(std::span<const T> values) {
  T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest();
  std::uint64_t finite = values.size();
  if constexpr (std::is_floating_point_v<T>) {
    finite = 0;
    // Selections instead of branches, so that the compiler vectorises the loop.
    for (const T v : values) {
      const bool is_finite = std::abs(v) <= std::numeric_limits<T>::max();
      finite += is_finite;
      low = is_finite && v < low ? v : low;
      high = is_finite && v > high ? v : high;
    }
  } else {
    for (const T v : values) low = v < low ? v : low;
    for (const T v : values) high = v > high ? v : high;
  }
  if (finite == 0) return {};
  return {double(low), double(high), finite};
}

/// Counts of each 8-bit pattern; four tables, so that runs of one value do not wait for each other.
std::array<std::uint64_t, 256> count_bytes(std::span<const std::byte> values) {
  std::array<std::array<std::uint64_t, 256>, 4> counts{};
  for (std::size_t i = 0; i < values.size(); ++i) ++counts[i & 3][std::size_t(values[i])];
  std::array<std::uint64_t, 256> sum{};
  for (const auto& table : counts)
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += table[i];
  return sum;
}

}  // namespace

ValueRange::ValueRange()
    : low(std::numeric_limits<double>::infinity()), high(-std::numeric_limits<double>::infinity()) {}

void ValueRange::add(ScalarType type, std::span<const std::byte> bytes) {
  for_values(type, bytes, [&](auto values) {
    const Extremes found = extremes(values);
    low = std::min(low, found.low);
    high = std::max(high, found.high);
    finite += found.finite;
    not_finite += values.size() - found.finite;
  });
}

void ValueRange::merge(const ValueRange& other) {
  low = std::min(low, other.low);
  high = std::max(high, other.high);
  finite += other.finite;
  not_finite += other.not_finite;
}

void Histogram::add(ScalarType type, std::span<const std::byte> bytes) {
  if (counts.empty()) return;
  const auto bins = double(counts.size());
  const double scale = high > low ? bins / (high - low) : 0.0;
  const auto count = [&](double value, std::uint64_t times) {
    // False also for NaN; infinities lie outside.
    if (!(value >= low && value <= high)) return;
    counts[std::size_t(std::min((value - low) * scale, bins - 1))] += times;
  };
  for_values(type, bytes, [&](auto values) {
    using T = typename decltype(values)::value_type;
    if constexpr (sizeof(T) == 1) {
      const auto patterns = count_bytes(bytes);
      for (std::size_t i = 0; i < patterns.size(); ++i)
        if (patterns[i] != 0) count(double(static_cast<T>(i)), patterns[i]);
    } else {
      for (const auto value : values) count(double(value), 1);
    }
  });
}

void Histogram::merge(const Histogram& other) {
  for (std::size_t i = 0; i < std::min(counts.size(), other.counts.size()); ++i) counts[i] += other.counts[i];
  below += other.below;
  above += other.above;
}

std::uint64_t Histogram::total() const {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

double Histogram::quantile(double fraction) const {
  const double wanted = std::clamp(fraction, 0.0, 1.0) * double(total());
  const double width = (high - low) / double(std::max<std::size_t>(counts.size(), 1));
  double seen = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto here = double(counts[i]);
    if (here > 0 && seen + here >= wanted) return low + width * (double(i) + (wanted - seen) / here);
    seen += here;
  }
  return counts.empty() || seen == 0 ? low : high;
}

}  // namespace ringsplat

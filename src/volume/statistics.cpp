#include "ringsplat/volume/statistics.hpp"

#include <algorithm>
#include <numeric>

#include "volume/scalars.hpp"

namespace ringsplat {

void ValueRange::add(ScalarType type, std::span<const std::byte> bytes) {
  for_values(type, bytes, [&](auto values) {
    using T = typename decltype(values)::value_type;
    T least = std::numeric_limits<T>::max(), most = std::numeric_limits<T>::lowest();
    std::uint64_t count = 0;
    // Selections instead of branches, so that the compiler vectorises the loop.
    for (const T v : values) {
      const bool counts = is_finite(v);
      count += counts;
      least = counts && v < least ? v : least;
      most = counts && v > most ? v : most;
    }
    if (count > 0) merge({double(least), double(most), 0, 0});
    finite += count;
    not_finite += values.size() - count;
  });
}

void ValueRange::merge(const ValueRange& other) {
  low = std::min(low, other.low);
  high = std::max(high, other.high);
  finite += other.finite;
  not_finite += other.not_finite;
}

void Histogram::add(double value, std::uint64_t times) {
  // False also for NaN; infinities lie outside.
  if (counts.empty() || !(value >= low && value <= high)) return;
  const auto bins = double(counts.size());
  const double scale = high > low ? bins / (high - low) : 0.0;
  counts[std::size_t(std::min((value - low) * scale, bins - 1))] += times;
}

void Histogram::add(ScalarType type, std::span<const std::byte> bytes) {
  for_values(type, bytes, [&](auto values) {
    for (const auto value : values) add(double(value), 1);
  });
}

std::uint64_t Histogram::total() const {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

}  // namespace ringsplat

#include "ringsplat/volume/statistics.hpp"

#include <algorithm>
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

}  // namespace

void ValueRange::add(ScalarType type, std::span<const std::byte> bytes) {
  for_values(type, bytes, [&](auto values) {
    using T = typename decltype(values)::value_type;
    T least = std::numeric_limits<T>::max(), most = std::numeric_limits<T>::lowest();
    std::uint64_t count = values.size();
    if constexpr (std::is_floating_point_v<T>) {
      count = 0;
      // Selections instead of branches, so that the compiler vectorises the loop.
      for (const T v : values) {
        const bool is_finite = std::abs(v) <= std::numeric_limits<T>::max();
        count += is_finite;
        least = is_finite && v < least ? v : least;
        most = is_finite && v > most ? v : most;
      }
    } else {
      for (const T v : values) least = v < least ? v : least;
      for (const T v : values) most = v > most ? v : most;
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

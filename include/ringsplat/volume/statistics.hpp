#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// Smallest and largest finite value, and how many values are not finite.
struct ValueRange {
  /// low > high while no finite value was seen.
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  std::uint64_t finite = 0, not_finite = 0;
  void add(ScalarType type, std::span<const std::byte> values);
  void merge(const ValueRange& other);
  bool empty() const { return finite == 0; }
};

/// Counts of the finite values in equal bins over [low, high]; the last bin includes `high`.
struct Histogram {
  double low = 0, high = 1;
  std::vector<std::uint64_t> counts;
  std::uint64_t below = 0, above = 0;  ///< finite values outside, when its maker knows them
  Histogram() = default;
  Histogram(double low_value, double high_value, int bins)
      : low(low_value), high(high_value), counts(std::size_t(bins)) {}
  void add(double value, std::uint64_t times);
  void add(ScalarType type, std::span<const std::byte> values);
  std::uint64_t total() const;
};

}  // namespace ringsplat

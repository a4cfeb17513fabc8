#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// Smallest and largest finite value, and how many values are not finite.
struct ValueRange {
  double low, high;  ///< low > high while no finite value was seen
  std::uint64_t finite = 0, not_finite = 0;
  ValueRange();
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
  void add(ScalarType type, std::span<const std::byte> values);
  void merge(const Histogram& other);  ///< same bins
  std::uint64_t total() const;
  double bin_centre(std::size_t bin) const {
    return low + (high - low) * (double(bin) + 0.5) / double(counts.size());
  }
  /// The value below which `fraction` of the counted voxels lie.
  double quantile(double fraction) const;
};

}  // namespace ringsplat

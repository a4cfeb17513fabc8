#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/statistics.hpp"

namespace ringsplat {

/// What the values of a volume are.
struct ValueKind {
  ScalarType type = ScalarType::uint8;
  std::optional<double> fill = std::nullopt;  ///< voxels of this value are not counted
};

/// Calls `f(values)` with spans of `kind.type` that hold all values but the fill value, in order; returns how
/// many voxels had the fill value.
std::uint64_t for_each_unfilled(const ValueKind& kind, std::span<const std::byte> values,
                                const std::function<void(std::span<const std::byte>)>& f);

/// Up to `most` different values; overflown when there were more, or some that are no whole numbers.
class DistinctValues {
 public:
  static constexpr std::size_t most = 16384;
  void add(double value) {
    if (overflown_ || value == last_) return;
    last_ = value;
    values_.insert(value);
    if (values_.size() > most || value != std::floor(value)) overflow();
  }
  void overflow() {
    overflown_ = true;
    values_ = {};
  }
  bool overflown() const { return overflown_; }
  std::vector<double> sorted() const {
    std::vector<double> values(values_.begin(), values_.end());
    std::ranges::sort(values);
    return values;
  }

 private:
  std::unordered_set<double> values_;
  double last_ = std::numeric_limits<double>::quiet_NaN();
  bool overflown_ = false;
};

/// Counts of the finite values by 16-bit keys that have the values' order: every value of an 8- or 16-bit
/// type has its own; those of wider types share the sign, exponent and first 7 bits of the mantissa of their
/// float32. So a single value far outside cannot flatten them.
class ValueTally {
 public:
  static constexpr std::size_t most_keys = 65536;

  explicit ValueTally(const ValueKind& kind);
  void add(std::span<const std::byte> values);

  /// The first value of a key and of the next one; equal for 8- and 16-bit types.
  struct Edges {
    double low, high;
  };
  static Edges edges_of(ScalarType type, std::size_t key);
  /// True when every value of the type has its own key.
  static bool is_exact(ScalarType type) { return size_of(type) <= 2; }

  const ValueKind& kind() const { return kind_; }

  ValueRange range;
  std::uint64_t fill = 0;             ///< voxels with the fill value
  std::vector<std::uint64_t> counts;  ///< by key
  DistinctValues distinct;            ///< of wide types, while all values are whole numbers

 private:
  ValueKind kind_;
};

/// Voxels whose values are in [low, high); of the value `low` alone where the two are equal.
struct ValueBin {
  double low, high;
  std::uint64_t count;
  double middle() const { return low + 0.5 * (high - low); }
};
using Bins = std::vector<ValueBin>;
/// Voxels of all bins.
double count_of(const Bins& bins);

/// Pairs of neighbours along rows, of large volumes some rows, where there are few different whole numbers.
struct NeighbourCounts {
  std::uint64_t equal = 0;     ///< pairs of one value
  std::uint64_t adjacent = 0;  ///< of a value and the next larger one that the volume has
  std::uint64_t apart = 0;     ///< of values with others between them
  std::uint64_t alone = 0;     ///< voxels unlike both of their neighbours
};

/// What is known of a volume's values. The fill value counts nowhere but in `fill_voxels`.
struct ValueStatistics {
  Grid grid = {};
  ValueRange range;  ///< exact
  /// Equal bins over the range; without the outliers where a few voxels lie so far outside all others that
  /// they would flatten it. Those are counted in `below` and `above`.
  Histogram histogram;
  /// Ascending and not empty: the histogram's bins and finer ones where the values are dense.
  Bins bins;
  std::uint64_t fill_voxels = 0;
  /// All values, ascending, when they are few different whole numbers; else empty.
  std::vector<double> labels;
  std::optional<NeighbourCounts> neighbours;  ///< when `labels` are few enough to be looked at
  VolumeNotes notes = {};

  /// The value below which `share` of the voxels lie; exact to a bin.
  double quantile(double share) const;
  /// The side of the smallest voxel, in those of a pyramid's finest level.
  double coarseness() const;
};

/// Calls its argument with all values of the volume, slice by slice, and the voxels of a row.
using RowVisitor = std::function<void(std::span<const std::byte> rows, int width)>;
using Pass = std::function<void(const RowVisitor&)>;

/// Reads `count` z slices from `first` on, some MiB at a time, and passes each on.
void visit_slices(VolumeSource& source, int first, int count, const RowVisitor& visit);

/// Puts together what processes have counted. One process has nothing to do.
struct Merging {
  std::function<void(ValueTally&)> merge = [](ValueTally&) {};
  std::function<void(std::vector<std::uint64_t>&)> sum = [](std::vector<std::uint64_t>&) {};
};

/// Goes through the values one to three times: counts by key, equal bins of types whose values have no key of
/// their own, and neighbours where there are few different whole numbers. The same on all processes, for any
/// number of them.
ValueStatistics describe_values(const Grid& grid, const VolumeNotes& notes, const Pass& pass,
                                const Merging& merging = {});

/// Of a histogram alone.
ValueStatistics describe_values(const Histogram& histogram);

/// Fewer bins, which add up those of `histogram`.
Histogram coarser(const Histogram& histogram, int bins);

/// The first and the last bin that are no outliers. Outliers are at most a ten-thousandth of the voxels at
/// either end, or one, which lie farther from the rest than fifty times its width. `bins` is not empty.
struct KeptBins {
  std::size_t first, last;
};
KeptBins without_outliers(const Bins& bins);

/// The values as labels: a mask; at most 16 whole numbers of which 0 is the most frequent, or more of them
/// whose neighbours are any others, in pieces of one value. False for scans whose neighbours are mostly the
/// next ones, and for noise.
bool look_like_labels(const ValueStatistics& values);

}  // namespace ringsplat

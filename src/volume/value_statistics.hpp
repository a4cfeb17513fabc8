#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/volume/source.hpp"
#include "volume/value_tally.hpp"

namespace ringsplat {

/// Voxels whose values are in [low, high); of the value `low` alone where the two are equal.
struct ValueBin {
  double low, high;
  std::uint64_t count;
  double middle() const { return low + 0.5 * (high - low); }
};

/// Pairs of neighbours along rows, in volumes of few different whole numbers.
struct NeighbourCounts {
  std::uint64_t equal = 0;     ///< pairs of one value
  std::uint64_t adjacent = 0;  ///< of a value and the next larger one that the volume has
  std::uint64_t apart = 0;     ///< of values with others between them
  std::uint64_t alone = 0;     ///< voxels unlike both of their neighbours
};

/// What is known of a volume's values. The fill value counts nowhere but in `fill_voxels`.
struct ValueStatistics {
  ValueKind kind;
  glm::ivec3 dims{1};
  ValueRange range;  ///< exact
  /// Equal bins over the range; without the outliers where a few voxels lie so far outside all others that
  /// they would flatten it. Those are counted in `below` and `above`.
  Histogram histogram;
  /// Ascending and not empty: the histogram's bins and finer ones where the values are dense.
  std::vector<ValueBin> bins;
  std::uint64_t fill_voxels = 0;
  std::vector<double>
      labels;  ///< all values, ascending, when they are few different whole numbers; else empty
  std::optional<NeighbourCounts> neighbours;  ///< when `labels` are few enough to be looked at
  std::string modality = {};                  ///< as in VolumeNotes
  World world = World::lattice;
  bool noted_labels = false;  ///< the file says that its values are labels

  std::uint64_t total() const;
  /// The value below which `share` of the voxels lie; exact to a bin.
  double quantile(double share) const;
};

/// Calls its argument with all values of the volume, some rows at a time, and the voxels of a row.
using RowVisitor = std::function<void(std::span<const std::byte> rows, int width)>;
using Pass = std::function<void(const RowVisitor&)>;

/// Puts together what processes have counted. One process has nothing to do.
class Merging {
 public:
  virtual ~Merging() = default;
  virtual void merge(ValueTally&) {}
  virtual void sum(std::vector<std::uint64_t>&) {}
};

/// Goes through the values two or three times: counts by key, equal bins, and neighbours where there are few
/// different whole numbers. The same on all processes, for any number of them.
ValueStatistics describe_values(const ValueKind& kind, glm::ivec3 dims, const VolumeNotes& notes,
                                const Pass& pass, Merging& merging);

/// Of a histogram alone.
ValueStatistics describe_values(const Histogram& histogram);

/// The first and the last bin that are no outliers. Outliers are at most a ten-thousandth of the voxels at
/// either end, or one, which lie farther from the rest than fifty times its width. `bins` is not empty.
struct KeptBins {
  std::size_t first, last;
};
KeptBins without_outliers(const std::vector<ValueBin>& bins);

/// The values as labels: a mask; at most 16 whole numbers of which 0 is the most frequent, or more of them
/// whose neighbours are any others, in pieces of one value. False for scans whose neighbours are mostly the
/// next ones, and for noise.
bool look_like_labels(const ValueStatistics& values);

}  // namespace ringsplat

#pragma once
#include <optional>

#include "volume/value_statistics.hpp"

/// What stands out in a volume's values: a fill value, outliers, the background, plateaus.
namespace ringsplat {

/// The upper bound of the bin in which `share` of the voxels, counted from below, is reached.
double upper_quantile(const Bins& bins, double share);
/// The share of voxels in bins whose middle is in [low, high).
double share_within(const Bins& bins, double low, double high);

/// The volume's values without what is no datum: a fill value, and a few voxels far outside.
struct Data {
  Bins bins;
  std::optional<double> fill_below, fill_above;  ///< a value far outside that many voxels have
  double filled = 0, outside = 0;                ///< voxels
  double outlier = 0;                            ///< the farthest one
  bool outside_below = false, outside_above = false;
  double all = 0;      ///< voxels, these included
  double depth = 128;  ///< voxels along a ray through the volume, of a pyramid its finest level

  double low() const { return bins.front().low; }
  double high() const { return bins.back().high; }
};
/// `values` have at least one bin.
Data data_of(const ValueStatistics& values);

/// The bins that are no background.
struct Foreground {
  bool upward = true;       ///< values grow away from the background
  Bins bins;                ///< ascending values
  double edge = 0;          ///< where the background ends
  bool background = false;  ///< there is one
};
/// Background is the highest peak with at least a tenth of the voxels beyond which next to nothing lies on
/// one side; of two values the smaller; 0 where it is the most frequent of few.
/// Or noise about an offset, up to where its upper flank ends.
Foreground find_foreground(const Data& data);

/// A value inside the object that many voxels have: an even part of it.
struct Plateau {
  double value, voxels;
};
/// Cuts single bins that stand out of their neighbours down to these, so that shares of voxels are those of
/// the values about them; returns the highest that has more than a tenth of `all` voxels.
std::optional<Plateau> flatten_plateaus(Bins& bins, double all);

}  // namespace ringsplat

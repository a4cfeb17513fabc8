#pragma once
#include <cmath>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// low < high, both finite, their distance perhaps beyond the largest double.
struct DataRange {
  double low, high;
  double at(double share) const { return std::lerp(low, high, share); }
};

/// The histogram's range, widened about its value when that is only one; 0..1 for an empty histogram.
DataRange range_of(const Histogram& histogram);

/// A transfer function for data of which nothing but the histogram is known.
///
/// A peak of at least a tenth of the voxels at the lower or the upper end of the values is background and
/// clear. Of the rest, common values are translucent and rare ones, farthest from the background, nearly
/// opaque. A volume of several values is never clear throughout; one of a single value is an even haze.
TransferFunction auto_preset(const Histogram& histogram);

}  // namespace ringsplat

#pragma once
#include <cmath>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// low < high, both finite; their difference may overflow a double.
struct DataRange {
  double low, high;
  double at(double share) const { return std::lerp(low, high, share); }
};

/// The histogram's range; widened if it is a single value, 0..1 if the histogram is empty.
DataRange range_of(const Histogram& histogram);

/// A transfer function for data of which nothing but the histogram is known.
///
/// A peak of at least a tenth of the voxels at either end of the values is background, and transparent. Of
/// the rest, common values are translucent, and rare ones, farthest from the background, nearly opaque. A
/// volume of several values is never wholly transparent; one of a single value is an even haze.
TransferFunction auto_preset(const Histogram& histogram);

}  // namespace ringsplat

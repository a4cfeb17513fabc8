#pragma once
#include <optional>
#include <string>
#include <vector>

#include "classify/adjust.hpp"
#include "ringsplat/classify/mode.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat {

/// The histogram's range; widened if it is a single value, 0..1 if the histogram is empty.
DataRange range_of(const Histogram& histogram);

/// A transfer function, and in one line what it is and why.
struct AutoChoice {
  TransferFunction function;
  std::string why;
  bool labels = false;      ///< a colour for each value
  DataRange range{0, 1};    ///< that it spans
  bool hounsfield = false;  ///< the values are a CT's, in Hounsfield units
};

/// A transfer function for data of which nothing but the values' statistics is known. The first that fits:
///
/// - a single value: an even haze;
/// - labels: a colour each (label_function);
/// - CT in Hounsfield units, by the modality or by range, air and soft tissue: "ct-soft", or "ct-bone" where
///   there is more bone than tissue;
/// - both signs about zero: diverging colours, zero clear;
/// - positive values of which nearly all are below a tenth of the largest, over three decades and more:
///   points at logarithmic steps;
/// - all else: a peak of at least a tenth of the voxels at either end of the values is background, and
///   transparent. Of the rest, common values are translucent, and rare ones, farthest from the background,
///   nearly opaque.
///
/// A value at either end that is far from all others is a fill value, which is clear; a few voxels that are
/// still farther are left out. Opacities are scaled where a ray through the object would see next to nothing
/// or only its surface. A volume of several values is never wholly transparent.
AutoChoice choose_function(const ValueStatistics& values);

/// Clear at the window's low end to nearly opaque at its high end, by the shares of the voxels within;
/// `logarithmic`: for a positive window, at logarithmic steps.
AutoChoice choose_within(const ValueStatistics& values, const DataRange& window, bool logarithmic);

/// From the positive value below which a hundredth of the positive ones lies to the largest. Throws
/// InputError when nothing is positive.
DataRange positive_range(const ValueStatistics& values);

/// The colours of a mode's values: grey from black at the low end of `window` to white at its high end, which
/// is chosen where it is not given; opaque throughout. Of a surface one colour for all values.
AutoChoice choose_for_mode(Mode mode, const ValueStatistics& values, const std::optional<DataRange>& window);

/// The value that parts the volume's values best into two classes (Otsu 1979).
double parting_value(const ValueStatistics& values);

/// The colours of labels, whatever the values look like. Throws InputError when they are no labels: not whole
/// numbers, or too many different ones.
AutoChoice choose_labels(const ValueStatistics& values);

/// A transfer function in which each of `labels` (whole numbers, ascending) has a colour of its own and
/// nearly full opacity, up to half-way to the next whole numbers; 0 and numbers that are no label are clear.
///
/// A label's colour depends on its number alone, so that it is the same in every volume.
TransferFunction label_function(const std::vector<double>& labels);

/// The display colour of a label, and the opacity of a voxel with one.
glm::dvec3 label_colour(double label);
inline constexpr double label_opacity = 0.9;

}  // namespace ringsplat

#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "classify/colour_maps.hpp"
#include "ringsplat/classify/transfer_function.hpp"

/// Changes of a transfer function.
namespace ringsplat {

/// low < high, both finite; their difference may overflow a double.
struct DataRange {
  double low, high;
  double at(double share) const { return std::lerp(low, high, share); }
  /// The same on a logarithmic axis, for positive ends.
  double at_logarithm(double share) const { return std::clamp(low * std::pow(high / low, share), low, high); }
};

/// Between the data and a value beyond them: half-way, but no further from them than they reach, so that a
/// value far away leaves an axis for them.
inline double beside(double value, const DataRange& data) {
  const double reach = data.high > data.low ? data.high - data.low : std::numeric_limits<double>::infinity();
  return value < data.low ? std::max(std::lerp(value, data.low, 0.5), data.low - reach)
                          : std::min(std::lerp(data.high, value, 0.5), data.high + reach);
}

/// 1 − (1 − α)^factor: twice as dense for 2.
void scale_opacity(TransferFunction& tf, double factor);

/// Moves all points linearly, so that the first and the last one of all lie at the range's ends.
void stretch(TransferFunction& tf, const DataRange& range);

/// A map's points over the range.
std::vector<TransferFunction::ColourPoint> colours_over(const ColourMap& map, const DataRange& range);

/// Wholly transparent below or above a value.
void clear_below(TransferFunction& tf, double value);
void clear_above(TransferFunction& tf, double value);
/// Transparent at a single value, and at the next representable ones to half-way to whole numbers for
/// `whole`.
void clear_at(TransferFunction& tf, double value, bool whole);

/// The first and the last of all points, of colours and opacities; they may be the same.
DataRange ends_of(const TransferFunction& tf);

/// Moves the points of positive values, each as far along the logarithm's axis from the first to the last
/// point as it was along the values', and puts more points in between, so that logarithms are interpolated.
TransferFunction on_logarithmic_axis(const TransferFunction& tf);
std::vector<TransferFunction::ColourPoint> on_logarithmic_axis(
    std::vector<TransferFunction::ColourPoint> points);

/// Only puts more points in between, so that logarithms are interpolated.
TransferFunction at_logarithmic_steps(const TransferFunction& tf);

}  // namespace ringsplat

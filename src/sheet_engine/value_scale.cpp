#include "sheet_engine/value_scale.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "classify/adjust.hpp"

namespace ringsplat {
namespace {

/// What stands for infinite values: some beyond the transfer function's ends, as in the truths.
std::pair<double, double> beyond_function(const TransferFunction& tf) {
  const auto [first, last] = ends_of(tf);
  return {first - 1 - std::abs(first), last + 1 + std::abs(last)};
}

/// The ends of the table's axis, as far as outliers do not change them.
std::pair<double, double> finite_range(const TransferFunction& tf, double low, double high) {
  const auto [below, above] = beyond_function(tf);
  if (!std::isfinite(low)) low = below;
  if (!std::isfinite(high)) high = above;
  if (!(low <= high)) std::swap(low, high);
  // A volume of a single value needs an axis, too.
  if (!(low < high)) high = low + std::max(1.0, std::abs(low) * 1e-3);
  return {low, high};
}

/// Narrows a range that the table could not resolve the function in. From a voxel so many widths of the
/// function away, all but a ten-thousandth of the way to its neighbour lies beyond the function's ends, so
/// that how far beyond does not matter. Returns whether there was something to leave out.
bool leave_outliers(const TransferFunction& tf, double& low, double& high) {
  const auto [first, last] = ends_of(tf);
  constexpr double widths = 1e4;
  const double reach = widths * (last - first), from = std::max(low, first - reach),
               to = std::min(high, last + reach);
  const bool cut = (from > low || to < high) && from < to;
  if (cut) low = from, high = to;
  return cut;
}

}  // namespace

ValueScale value_scale(const SheetFrame& frame, double low, double high) {
  const TransferFunction& tf = frame.shown.transfer_function;
  ValueScale scale;
  std::tie(scale.low, scale.high) = finite_range(tf, low, high);
  const bool cut = frame.composites() && leave_outliers(tf, scale.low, scale.high);
  const bool rounded = frame.composites() && !frame.nearest() && TableAxis(tf, scale.low, scale.high).even();
  PlaneCode& code = scale.code;
  code = PlaneCode::choose(frame.geometry.grid.type, scale.low, scale.high, rounded, frame.slabs());
  // Only where there are any, so that planes can be kept when the function changes.
  if (!std::isfinite(low) || !std::isfinite(high)) std::tie(code.below, code.above) = beyond_function(tf);
  if (cut) code.least = scale.low, code.most = scale.high;
  return scale;
}

}  // namespace ringsplat

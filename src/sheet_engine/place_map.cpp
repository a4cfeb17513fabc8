#include "sheet_engine/place_map.hpp"

#include <ranges>
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

/// Where planes' numbers are rounded the ends are, too, so that what lies in an interval does so after
/// rounding. A place counts as transparent up to and with `visible_low`, so an end that is visible lies
/// beyond it.
void set_transparent(PlaceMap& map, const TransparentValues& transparent, const ValueScale& scale) {
  const auto place = [&](double value) {
    const double number = scale.code.of(std::clamp(value, scale.low, scale.high));
    return place_of_number(map, float(scale.code.rounds() ? std::round(number) : number));
  };
  constexpr float before_all = no_place, after_all = -no_place;
  map.visible_low = before_all;
  map.visible_high = after_all;
  for (const auto& i : transparent.intervals()) {
    if (i.high < scale.low || i.low > scale.high) continue;
    const float low = i.low < scale.low ? before_all
                      : i.has_low       ? place(i.low)
                                        : std::nextafter(place(i.low), after_all),
                high = i.high > scale.high ? after_all
                       : i.has_high        ? place(i.high)
                                           : std::nextafter(place(i.high), before_all);
    if (!std::isfinite(i.low))
      map.visible_low = high;
    else if (!std::isfinite(i.high))
      map.visible_high = low;
    else
      map.gaps[std::size_t(map.gap_count++)] = {low, high};
  }
}

/// Of what is transparent by place, the planes' whole numbers, less one at each end: sums of them are divided
/// with rounding.
void set_transparent_numbers(PlaceMap& map) {
  const auto first_number = [&](auto&& beyond) {
    const auto numbers = std::views::iota(int{INT16_MIN}, int{INT16_MAX} + 1);
    return int(std::ranges::partition_point(numbers,
                                            [&](int n) { return !beyond(place_of_number(map, float(n))); }) -
               numbers.begin()) +
           INT16_MIN;
  };
  const auto within = [](int number) { return std::int16_t(std::clamp<int>(number, INT16_MIN, INT16_MAX)); };
  const auto first_from = [&](float place) {
    return within(first_number([place](float p) { return p >= place; }) + 1);
  };
  const auto last_to = [&](float place) {
    return within(first_number([place](float p) { return p > place; }) - 2);
  };
  map.transparent = {last_to(map.visible_low), first_from(map.visible_high)};
  for (std::size_t k = 0; k < std::size_t(map.gap_count); ++k)
    map.number_gaps[k] = {first_from(map.gaps[k].low), last_to(map.gaps[k].high)};
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
  code.labelled = frame.tinted();
  if (cut) code.least = scale.low, code.most = scale.high;
  return scale;
}

PlaceMap place_map(const SheetFrame& frame, const ValueScale& scale, const TableAxis& axis) {
  PlaceMap map;
  map.count = axis.count;
  map.even = axis.coarse || (axis.even() && !scale.code.floats);
  for (int k = 0; k < axis.count; ++k) {
    const auto& ramp = axis.ramps[std::size_t(k)];
    map.ramps[std::size_t(k)] = {float(scale.code.of(ramp.from)), float(ramp.width * scale.code.scale),
                                 float(ramp.rise / scale.code.scale)};
  }
  const double a_number = axis.ramps[0].rise / scale.code.scale;
  map.scale = float(a_number);
  map.offset = float(-scale.code.of(axis.ramps[0].from) * a_number);
  set_transparent(map, frame.transparent, scale);
  if (!scale.code.floats) set_transparent_numbers(map);
  return map;
}

PlaceMap place_map(const SheetFrame& frame, const ValueScale& scale, const ValueTable& values) {
  PlaceMap map;
  const double a_number = values.steps_a_unit() / scale.code.scale;
  map.even = true;
  map.scale = float(a_number);
  map.offset = float(-scale.code.of(values.low()) * a_number);
  set_transparent(map, frame.transparent, scale);
  return map;
}

}  // namespace ringsplat

#include "sheet_engine/place_map.hpp"

#include <algorithm>
#include <cmath>

namespace ringsplat {
namespace {

/// Ends are rounded as the planes' numbers are, so that what lies in an interval does so after rounding. A
/// place counts as transparent up to and with `visible_low`, so an end that is visible lies beyond it.
void set_transparent(PlaceMap& map, const TransparentValues& transparent, const ValueScale& scale) {
  const auto place = [&](double value) {
    const double number = scale.code.of(std::clamp(value, scale.low, scale.high));
    return place_of_number(map, float(scale.code.floats ? number : double(std::lround(number))));
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

}  // namespace

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

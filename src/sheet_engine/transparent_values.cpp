#include "sheet_engine/transparent_values.hpp"

#include <cmath>

#include "classify/adjust.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

bool is_gap(const TransparentValues::Interval& i) { return std::isfinite(i.low) && std::isfinite(i.high); }

}  // namespace

TransparentValues::TransparentValues(const TransferFunction& tf) {
  const auto& points = tf.opacities;
  const auto add = [this](double low, double high) {
    if (!intervals_.empty() && intervals_.back().high == low)
      intervals_.back().high = high;
    else
      intervals_.push_back({low, high, true, true});
  };
  if (points.front().opacity == 0) add(-infinity, points.front().value);
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    if (points[i].opacity == 0 && points[i + 1].opacity == 0) add(points[i].value, points[i + 1].value);
  if (points.back().opacity == 0) add(points.back().value, infinity);
  for (Interval& i : intervals_) {
    i.has_low = !std::isfinite(i.low) || tf.evaluate(i.low).opacity == 0;
    i.has_high = !std::isfinite(i.high) || tf.evaluate(i.high).opacity == 0;
  }
  // Keeps the widest gaps.
  while (std::count_if(intervals_.begin(), intervals_.end(), is_gap) > most_gaps) {
    const auto width = [](const Interval& i) { return is_gap(i) ? i.high - i.low : infinity; };
    intervals_.erase(std::ranges::min_element(intervals_, {}, width));
  }
}

TransparentValues transparent_values(const Shown& shown, ScalarType type) {
  using Intervals = std::vector<TransparentValues::Interval>;
  const TransparentValues clear(shown.transfer_function);
  const auto& intervals = clear.intervals();
  const bool low_end = !intervals.empty() && !std::isfinite(intervals.front().low),
             high_end = !intervals.empty() && !std::isfinite(intervals.back().high);
  const double clear_to = low_end ? intervals.front().high : -infinity,
               clear_from = high_end ? intervals.back().low : infinity;
  const auto [first, last] = ends_of(shown.transfer_function);
  const bool holes = shown.holes && !is_whole(type);
  switch (shown.mode) {
    case Mode::composite:
      return clear;
    case Mode::mip:
      if (holes && (shown.values || !low_end)) return {};
      // All extrema up to the function's first point look alike, and those that are clear.
      return TransparentValues(Intervals{{-infinity, std::max(clear_to, first), true, true}});
    case Mode::attenuated:
      return TransparentValues(
          Intervals{{-infinity, shown.transfer_function.colours.front().value, true, true}});
    case Mode::minip:
      if (holes && (shown.values || !high_end)) return {};
      return TransparentValues(Intervals{{std::min(clear_from, last), infinity, true, true}});
    case Mode::mean:
    case Mode::sum:
      return TransparentValues(Intervals{{0, 0, true, true}});
    case Mode::surface:
      return TransparentValues(
          Intervals{{-infinity, shown.isovalue, true, false}, {shown.isovalue, infinity, false, true}});
  }
  return clear;
}

int TransparentValues::holding(double low, double high) const {
  // An end that is visible itself: numbers of a Renderer's planes must not round to it.
  const auto apart = [](double end) { return 1e-6 * std::abs(end); };
  for (std::size_t k = 0; k < intervals_.size(); ++k) {
    const Interval& i = intervals_[k];
    if ((i.has_low ? low >= i.low : low > i.low + apart(i.low)) &&
        (i.has_high ? high <= i.high : high < i.high - apart(i.high)))
      return static_cast<int>(k);
  }
  return nowhere;
}

Fillers make_fillers(const TransparentValues& transparent, ScalarType type, double low, double high) {
  Fillers fillers;
  fillers.fill(low);
  fillers.back() = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < transparent.intervals().size(); ++k) {
    const auto& i = transparent.intervals()[k];
    const double within = !is_whole(type) ? 0.5 * (i.low + i.high)
                          : i.has_low     ? std::ceil(i.low)
                                          : std::floor(i.low) + 1;
    fillers[k] = !std::isfinite(i.low) ? low : !std::isfinite(i.high) ? high : std::clamp(within, low, high);
  }
  return fillers;
}

}  // namespace ringsplat

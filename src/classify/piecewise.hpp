#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// A value's place among ascending points: between points[index] and the next one.
struct Place {
  std::size_t index;
  double t;  ///< 0 at points[index], below 1; 0 also before the first and behind the last point
};

/// How far `value` is on its way from x0 to x1 > x0, in [0, 1]. The span may be beyond the largest double.
inline double fraction(double value, double x0, double x1) {
  const double span = x1 - x0;
  if (std::isfinite(span)) return std::min((value - x0) / span, 1.0);
  return std::min((0.5 * value - 0.5 * x0) / (0.5 * x1 - 0.5 * x0), 1.0);
}

/// `points` (at least one, with a member `value`) ascend; of equal values the last one holds at the value
/// itself. `value` is not NaN; infinities lie beyond the end points.
template <class Point>
Place locate(const std::vector<Point>& points, double value) {
  const auto above = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& p) { return v < p.value; });
  if (above == points.begin()) return {0, 0.0};
  const auto index = std::size_t(above - points.begin()) - 1;
  if (above == points.end()) return {index, 0.0};
  return {index, fraction(value, points[index].value, above->value)};
}

/// The points; add(all, k) puts others between points k and k + 1, where the values ascend.
template <class Point, class Add>
std::vector<Point> with_more(const std::vector<Point>& points, const Add& add) {
  std::vector<Point> all;
  for (std::size_t k = 0; k < points.size(); ++k) {
    all.push_back(points[k]);
    if (k + 1 < points.size() && points[k].value < points[k + 1].value) add(all, k);
  }
  return all;
}

/// Linear interpolation from `a` to `b`; exactly `a` when the two are equal.
template <class T>
T blend(const T& a, const T& b, double t) {
  return a + t * (b - a);
}

/// The opacity that a transfer function's points give a value.
inline double opacity_at(const std::vector<TransferFunction::OpacityPoint>& points, double value) {
  const auto [index, t] = locate(points, value);
  const double opacity = points[index].opacity;
  return t > 0 ? std::clamp(blend(opacity, points[index + 1].opacity, t), 0.0, 1.0) : opacity;
}

}  // namespace ringsplat

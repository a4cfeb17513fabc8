#include "classify/adjust.hpp"

#include "classify/piecewise.hpp"

namespace ringsplat {
namespace {

/// `points` with others in between, so that logarithms are interpolated. `look`: the points' other member.
template <class Point, class Look>
std::vector<Point> filled(const std::vector<Point>& points, Look Point::*look) {
  return with_more(points, [&](std::vector<Point>& all, std::size_t k) {
    const Point &a = points[k], &b = points[k + 1];
    constexpr double per_decade = 8;
    const int steps = std::clamp(int(std::ceil(per_decade * std::log10(b.value / a.value))), 1, 256);
    for (int i = 1; i < steps; ++i) {
      const double part = double(i) / steps;
      all.push_back({DataRange{a.value, b.value}.at_logarithm(part), blend(a.*look, b.*look, part)});
    }
  });
}

/// Moves points as far along the logarithm's axis as they were along the values'.
template <class Point>
void move_to_logarithms(std::vector<Point>& points, const DataRange& range) {
  for (Point& point : points) point.value = range.at_logarithm(fraction(point.value, range.low, range.high));
}

}  // namespace

void scale_opacity(TransferFunction& tf, double factor) {
  for (auto& point : tf.opacities)
    if (point.opacity > 0 && point.opacity < 1)
      point.opacity = std::clamp(-std::expm1(factor * std::log1p(-point.opacity)), 0.0, 1.0);
}

DataRange ends_of(const TransferFunction& tf) {
  return {std::min(tf.colours.front().value, tf.opacities.front().value),
          std::max(tf.colours.back().value, tf.opacities.back().value)};
}

void stretch(TransferFunction& tf, const DataRange& range) {
  const DataRange ends = ends_of(tf);
  const auto moved = [&](double value) {
    return ends.low < ends.high ? range.at(fraction(value, ends.low, ends.high)) : range.low;
  };
  for (auto& point : tf.colours) point.value = moved(point.value);
  for (auto& point : tf.opacities) point.value = moved(point.value);
}

std::vector<TransferFunction::ColourPoint> colours_over(const ColourMap& map, const DataRange& range) {
  auto points = map.points;
  for (auto& point : points) point.value = range.at(point.value);
  return points;
}

void clear_below(TransferFunction& tf, double value) {
  const double here = opacity_at(tf.opacities, value);
  std::erase_if(tf.opacities, [&](const auto& p) { return p.value <= value; });
  tf.opacities.insert(tf.opacities.begin(), {{value, 0.0}, {value, here}});
}

void clear_above(TransferFunction& tf, double value) {
  const double here = opacity_at(tf.opacities, value);
  std::erase_if(tf.opacities, [&](const auto& p) { return p.value >= value; });
  tf.opacities.insert(tf.opacities.end(), {{value, here}, {value, 0.0}});
}

void clear_at(TransferFunction& tf, double value, bool whole) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double low = whole ? value - 0.5 : std::nextafter(value, -infinity),
               high = whole ? value + 0.5 : std::nextafter(value, infinity);
  const double before = opacity_at(tf.opacities, low), after = opacity_at(tf.opacities, high);
  std::erase_if(tf.opacities, [&](const auto& p) { return p.value >= low && p.value <= high; });
  const auto at = std::ranges::find_if(tf.opacities, [&](const auto& p) { return p.value > high; });
  tf.opacities.insert(at, {{low, before}, {low, 0.0}, {high, 0.0}, {high, after}});
}

TransferFunction on_logarithmic_axis(const TransferFunction& tf) {
  TransferFunction moved = tf;
  move_to_logarithms(moved.colours, ends_of(tf));
  move_to_logarithms(moved.opacities, ends_of(tf));
  return at_logarithmic_steps(moved);
}

std::vector<TransferFunction::ColourPoint> on_logarithmic_axis(
    std::vector<TransferFunction::ColourPoint> points) {
  move_to_logarithms(points, {points.front().value, points.back().value});
  return filled(points, &TransferFunction::ColourPoint::srgb);
}

TransferFunction at_logarithmic_steps(const TransferFunction& tf) {
  TransferFunction out = tf;
  out.colours = filled(tf.colours, &TransferFunction::ColourPoint::srgb);
  out.opacities = filled(tf.opacities, &TransferFunction::OpacityPoint::opacity);
  return out;
}

}  // namespace ringsplat

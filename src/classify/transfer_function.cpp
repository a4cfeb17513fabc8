#include "ringsplat/classify/transfer_function.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/srgb.hpp"
#include "classify/piecewise.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

bool is_share(double v) { return v >= 0.0 && v <= 1.0; }
bool is_colour(const glm::dvec3& c) { return is_share(c.x) && is_share(c.y) && is_share(c.z); }

/// Checks the values of either kind of points.
template <class Point>
void check_values(const std::vector<Point>& points, const std::string& field) {
  if (points.size() < 2)
    throw InputError(fmt::format("{} has {} point{}", field, points.size(), points.size() == 1 ? "" : "s"),
                     "give at least two points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i].value))
      throw InputError(fmt::format("{}: the value of point {} is not finite", field, i + 1), "give a number");
    if (i > 0 && points[i].value < points[i - 1].value)
      throw InputError(fmt::format("{}: point {} at {} comes after point {} at {}", field, i + 1,
                                   points[i].value, i, points[i - 1].value),
                       "sort the points by their values");
  }
}

}  // namespace

TransferFunction::Sample TransferFunction::evaluate(double value) const {
  if (std::isnan(value)) return {srgb_to_linear(nan_srgb), 0.0};
  Sample sample{};
  const Place c = locate(colours, value);
  sample.colour = srgb_to_linear(colours[c.index].srgb);
  if (c.t > 0) sample.colour = blend(sample.colour, srgb_to_linear(colours[c.index + 1].srgb), c.t);
  sample.opacity = opacity_at(opacities, value);
  return sample;
}

bool TransferFunction::visible_within(double low, double high) const {
  if (!(low <= high)) return false;
  if (opacity_at(opacities, low) > 0 || opacity_at(opacities, high) > 0) return true;
  // Neither end is visible, so something is only if a piece between points is above zero in (low, high).
  for (std::size_t i = 0; i + 1 < opacities.size(); ++i) {
    const auto &a = opacities[i], &b = opacities[i + 1];
    if (a.value < b.value && a.value < high && b.value > low && (a.opacity > 0 || b.opacity > 0)) return true;
  }
  return false;
}

void check(const TransferFunction& tf, const std::string& where) {
  check_values(tf.colours, fmt::format("{}, RGBPoints", where));
  check_values(tf.opacities, fmt::format("{}, Points", where));
  for (std::size_t i = 0; i < tf.colours.size(); ++i)
    if (!is_colour(tf.colours[i].srgb))
      throw InputError(fmt::format("{}, RGBPoints: the colour of point {} is outside 0..1", where, i + 1),
                       "give red, green and blue from 0 to 1");
  for (std::size_t i = 0; i < tf.opacities.size(); ++i)
    if (!is_share(tf.opacities[i].opacity))
      throw InputError(fmt::format("{}, Points: the opacity {} of point {} is outside 0..1", where,
                                   tf.opacities[i].opacity, i + 1),
                       "give opacities from 0 (clear) to 1 (opaque)");
  if (!is_colour(tf.nan_srgb))
    throw InputError(fmt::format("{}, NanColor: the colour is outside 0..1", where),
                     "give red, green and blue from 0 to 1");
}

}  // namespace ringsplat

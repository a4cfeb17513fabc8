#include "classify/paraview_curves.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "base/srgb.hpp"
#include "classify/piecewise.hpp"

namespace ringsplat {
namespace {

constexpr double pi = std::numbers::pi;

// Hue, saturation, value (Smith 1978), all 0..1.

glm::dvec3 rgb_to_hsv(const glm::dvec3& c) {
  const double high = std::max({c.x, c.y, c.z}), low = std::min({c.x, c.y, c.z}), span = high - low;
  if (!(span > 0)) return {0.0, 0.0, high};
  double sixths = 0;
  if (c.x == high)
    sixths = (c.y - c.z) / span;
  else if (c.y == high)
    sixths = 2.0 + (c.z - c.x) / span;
  else
    sixths = 4.0 + (c.x - c.y) / span;
  return {(sixths < 0 ? sixths + 6.0 : sixths) / 6.0, span / high, high};
}

glm::dvec3 hsv_to_rgb(const glm::dvec3& c) {
  const auto channel = [&c](double offset) {
    const double k = std::fmod(offset + 6.0 * c.x, 6.0);
    return c.z - c.z * c.y * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0);
  };
  return {channel(5.0), channel(3.0), channel(1.0)};
}

template <bool wrap>
glm::dvec3 interpolate_hsv(const glm::dvec3& a, const glm::dvec3& b, double t) {
  glm::dvec3 from = rgb_to_hsv(a), to = rgb_to_hsv(b);
  if (wrap && from.x - to.x > 0.5) to.x += 1.0;
  if (wrap && to.x - from.x > 0.5) from.x += 1.0;
  glm::dvec3 mixed = blend(from, to, t);
  mixed.x -= std::floor(mixed.x);
  return hsv_to_rgb(mixed);
}

// CIE L*a*b* (CIE 15:2004) under D65.

const glm::dmat3 linear_to_xyz{0.4124, 0.2126, 0.0193, 0.3576, 0.7152, 0.1192, 0.1805, 0.0722, 0.9505};
constexpr glm::dvec3 white{0.9505, 1.0, 1.089};

glm::dvec3 rgb_to_lab(const glm::dvec3& srgb) {
  const auto f = [](double v) { return v > 0.008856 ? std::cbrt(v) : 7.787 * v + 16.0 / 116.0; };
  const glm::dvec3 xyz = (linear_to_xyz * srgb_to_linear(srgb)) / white;
  const double x = f(xyz.x), y = f(xyz.y), z = f(xyz.z);
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

glm::dvec3 lab_to_rgb(const glm::dvec3& lab) {
  const auto inverse_f = [](double v) {
    return v * v * v > 0.008856 ? v * v * v : (v - 16.0 / 116.0) / 7.787;
  };
  const double y = (lab.x + 16.0) / 116.0;
  const glm::dvec3 xyz{inverse_f(lab.y / 500.0 + y), inverse_f(y), inverse_f(y - lab.z / 200.0)};
  const glm::dvec3 light = glm::inverse(linear_to_xyz) * (xyz * white);
  return linear_to_srgb(glm::clamp(light, 0.0, 1.0));
}

glm::dvec3 interpolate_lab(const glm::dvec3& a, const glm::dvec3& b, double t) {
  return lab_to_rgb(blend(rgb_to_lab(a), rgb_to_lab(b), t));
}

// Moreland's polar form of Lab (Moreland 2009, "Diverging Color Maps for Scientific Visualization", section
// 5): magnitude, saturation angle, hue.

struct Msh {
  double m, s, h;
};

Msh lab_to_msh(const glm::dvec3& lab) {
  const double m = glm::length(lab);
  const double s = m > 0.001 ? std::acos(std::clamp(lab.x / m, -1.0, 1.0)) : 0.0;
  return {m, s, s > 0.001 ? std::atan2(lab.z, lab.y) : 0.0};
}

glm::dvec3 msh_to_lab(const Msh& c) {
  return {c.m * std::cos(c.s), c.m * std::sin(c.s) * std::cos(c.h), c.m * std::sin(c.s) * std::sin(c.h)};
}

/// The hue to give an unsaturated end so that the way to the saturated colour looks straight.
double adjusted_hue(const Msh& saturated, double unsaturated_m) {
  if (saturated.m >= unsaturated_m) return saturated.h;
  const double spin = saturated.s * std::sqrt(unsaturated_m * unsaturated_m - saturated.m * saturated.m) /
                      (saturated.m * std::sin(saturated.s));
  return saturated.h > -pi / 3 ? saturated.h + spin : saturated.h - spin;
}

glm::dvec3 interpolate_diverging(const glm::dvec3& a, const glm::dvec3& b, double t) {
  constexpr double grey = 0.05;
  Msh from = lab_to_msh(rgb_to_lab(a)), to = lab_to_msh(rgb_to_lab(b));
  double apart = std::abs(from.h - to.h);
  if (apart > pi) apart = 2 * pi - apart;
  if (from.s > grey && to.s > grey && apart > pi / 3) {
    const double middle = std::max({from.m, to.m, 88.0});
    if (t < 0.5) {
      to = {middle, 0, 0};
      t = 2 * t;
    } else {
      from = {middle, 0, 0};
      t = 2 * t - 1;
    }
  }
  if (from.s < grey && to.s > grey)
    from.h = adjusted_hue(to, from.m);
  else if (to.s < grey && from.s > grey)
    to.h = adjusted_hue(from, to.m);
  return lab_to_rgb(
      msh_to_lab({std::lerp(from.m, to.m, t), std::lerp(from.s, to.s, t), std::lerp(from.h, to.h, t)}));
}

// Opacities.

constexpr double nearly_linear = 0.01, nearly_step = 0.99;  // VTK's thresholds
constexpr int pieces_each_side = 256;

CurveShape limited(CurveShape shape) {
  shape.midpoint = std::clamp(shape.midpoint, 1e-5, 1.0 - 1e-5);
  return shape;
}

}  // namespace

ColourCurve colour_curve(const std::string& space, bool hsv_wrap) {
  if (space == "HSV") return hsv_wrap ? interpolate_hsv<true> : interpolate_hsv<false>;
  if (space == "Lab" || space == "CIELAB") return interpolate_lab;
  return space == "Diverging" ? interpolate_diverging : nullptr;
}

double shaped_opacity(double y0, double y1, const CurveShape& given, double t) {
  const CurveShape shape = limited(given);
  // Moves t so that the midpoint becomes 0.5.
  double s = t < shape.midpoint ? 0.5 * t / shape.midpoint
                                : 0.5 + 0.5 * (t - shape.midpoint) / (1.0 - shape.midpoint);
  // VTK's curve (class vtkPiecewiseFunction): a power presses t together about its middle; a cubic Hermite
  // curve with the same slope at both ends follows.
  const double power = 1.0 + 10.0 * shape.sharpness;
  s = s < 0.5 ? 0.5 * std::pow(2.0 * s, power) : 1.0 - 0.5 * std::pow(2.0 * (1.0 - s), power);
  const double slope = (1.0 - shape.sharpness) * (y1 - y0);
  const double smooth = s * s * (3.0 - 2.0 * s);
  const double y = y0 + (y1 - y0) * smooth + slope * s * (1.0 - s) * (1.0 - 2.0 * s);
  return std::clamp(y, std::min(y0, y1), std::max(y0, y1));
}

std::vector<TransferFunction::OpacityPoint> sample_shapes(
    const std::vector<TransferFunction::OpacityPoint>& points, const std::vector<CurveShape>& shapes) {
  return with_more(points, [&](auto& out, std::size_t i) {
    const CurveShape shape = limited(shapes[i]);
    const double y0 = points[i].opacity, y1 = points[i + 1].opacity;
    const auto value_at = [&](double t) { return std::lerp(points[i].value, points[i + 1].value, t); };
    const double middle = value_at(shape.midpoint);
    if (shape.sharpness > nearly_step) {
      out.push_back({middle, y0});
      out.push_back({middle, y1});
    } else if (shape.sharpness < nearly_linear) {
      if (shapes[i].midpoint != 0.5) out.push_back({middle, 0.5 * (y0 + y1)});
    } else {
      for (int k = 1; k < 2 * pieces_each_side; ++k) {
        const double half = double(k) / pieces_each_side;
        const double t =
            half <= 1.0 ? half * shape.midpoint : shape.midpoint + (half - 1.0) * (1.0 - shape.midpoint);
        out.push_back({value_at(t), shaped_opacity(y0, y1, shape, t)});
      }
    }
  });
}

}  // namespace ringsplat

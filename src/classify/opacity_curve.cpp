#include "classify/opacity_curve.hpp"

#include <algorithm>
#include <cmath>

#include "classify/piecewise.hpp"

namespace ringsplat {
namespace {

constexpr double nearly_linear = 0.01, nearly_step = 0.99;  // VTK's thresholds
constexpr int pieces_each_side = 256;

CurveShape limited(CurveShape shape) {
  shape.midpoint = std::clamp(shape.midpoint, 1e-5, 1.0 - 1e-5);
  return shape;
}

}  // namespace

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

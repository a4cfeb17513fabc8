#pragma once
#include <string>

#include "ringsplat/classify/transfer_function.hpp"

/// How ParaView's colours and opacities run from one point to the next.
namespace ringsplat {

/// The display colour at `t` in [0, 1] on the way from `a` to `b`, up to roundings in 0..1.
using ColourCurve = glm::dvec3 (*)(const glm::dvec3& a, const glm::dvec3& b, double t);

/// Of a space other than RGB: "HSV", "Lab" or "CIELAB", "Diverging"; null for any other name.
ColourCurve colour_curve(const std::string& space, bool hsv_wrap);

/// Of opacities. `midpoint`: where half of the way is done, 0..1 of it. `sharpness`: from linear (0) to a
/// step (1).
struct CurveShape {
  double midpoint = 0.5, sharpness = 0.0;
};

/// The opacity at `t` in [0, 1] of the way from y0 to y1.
double shaped_opacity(double y0, double y1, const CurveShape& shape, double t);

/// Samples the curves as piecewise-linear points; shapes[i] is the piece from points[i] to the next. Exact
/// for linear pieces and steps, within 2e-4 otherwise.
std::vector<TransferFunction::OpacityPoint> sample_shapes(
    const std::vector<TransferFunction::OpacityPoint>& points, const std::vector<CurveShape>& shapes);

}  // namespace ringsplat

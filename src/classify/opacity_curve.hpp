#pragma once
#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// How ParaView's opacity runs from one point to the next. `midpoint`: where it is half done, 0..1 of the
/// way. `sharpness`: from linear (0) to a step (1).
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

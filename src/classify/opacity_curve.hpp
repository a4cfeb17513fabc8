#pragma once
#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// How ParaView's opacity runs from one point to the next: `midpoint` is where (0..1 of the way) it is half
/// done, `sharpness` goes from linear (0) to a step (1).
struct CurveShape {
  double midpoint = 0.5, sharpness = 0.0;
};

/// The opacity at `t` in [0, 1] of the way from y0 to y1.
double shaped_opacity(double y0, double y1, const CurveShape& shape, double t);

/// Piecewise-linear opacity points with the curve's course; shapes[i] belongs to the way from points[i] on.
/// Exact for linear pieces and steps, within 2e-4 otherwise.
std::vector<TransferFunction::OpacityPoint> sample_shapes(
    const std::vector<TransferFunction::OpacityPoint>& points, const std::vector<CurveShape>& shapes);

}  // namespace ringsplat

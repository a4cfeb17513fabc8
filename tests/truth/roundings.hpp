#pragma once
// The renderer's three roundings, each measured alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "splat/region_painter.hpp"
#include "splat/splat.hpp"
#include "view/slice_dda.hpp"

namespace ringsplat::test {

inline Footprint footprint_of_scale(double pixels_per_voxel) {
  ViewTransform view;
  view.linear = glm::dmat3(pixels_per_voxel);
  return make_footprint(view, Axis::z, 1.6);
}

/// Largest errors of screen positions in pixels over rows of `width` voxels, two pixels a voxel at most.
struct DriftErrors {
  double dda;          ///< the renderer's
  double running_sum;  ///< of a running sum of the step
};
inline DriftErrors drift_errors(int width) {
  const LatticeFrame lattice{{width, 8, 8}, glm::dvec3(1.0), glm::dvec3(0.0), glm::dmat3(1.0)};
  const ViewTransform view =
      make_view({.azimuth = 17, .elevation = 13, .roll = 5, .zoom = 1}, lattice, 2 * width, 2 * width);
  SliceDda dda(view, Axis::z, width);
  DriftErrors errors{0, 0};
  for (int row = 0; row < 8; ++row) {
    dda.begin_row(3, row);
    glm::dvec3 running = view.project({0, row, 3});
    for (int u = 0; u < width; ++u, running += view.linear[0])
      for (int k = 0; k < 2; ++k) {
        const auto exact = static_cast<long double>(view.linear[0][k]) * u +
                           static_cast<long double>(view.linear[1][k]) * row +
                           static_cast<long double>(view.linear[2][k]) * 3 +
                           static_cast<long double>(view.offset[k]);
        const auto error_of = [&](double position) {
          return double(std::abs(exact - static_cast<long double>(position)));
        };
        errors.dda = std::max(errors.dda, error_of(dda.position(std::uint32_t(u))[k]));
        errors.running_sum = std::max(errors.running_sum, error_of(running[k]));
      }
  }
  return errors;
}

/// Largest errors of Q over the kernel's pixels when the quadratic is evaluated in float32.
struct QuadraticErrors {
  double anchored;  ///< coefficients from the splat's own anchor, as in the renderer
  double absolute;  ///< coefficients from an origin `far` pixels away along x and y
};
inline QuadraticErrors quadratic_errors(double pixels_per_voxel, double far) {
  const Footprint footprint = footprint_of_scale(pixels_per_voxel);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(0, 1);
  QuadraticErrors errors{0, 0};
  for (int trial = 0; trial < 200; ++trial) {
    const double dx = within(random), dy = within(random);
    const auto near = coefficients(footprint, dx, dy), away = coefficients(footprint, dx + far, dy + far);
    const auto evaluate = [&](const Coefficients& q, double x, double y) {
      const auto a = float(q.a), b = float(q.b), c = float(q.c), d = float(footprint.d),
                 e = float(footprint.e), f = float(footprint.f);
      const auto px = float(x), py = float(y);
      return double(((d * px + e * py) * px + f * py * py) + a * px + (c + b * py));
    };
    const int reach = int(footprint.half.x) + 1;
    for (int y = -reach; y <= reach + 1; ++y)
      for (int x = -reach; x <= reach + 1; ++x) {
        const double exact =
            1 - (std::pow(x - dx, 2) + std::pow(y - dy, 2)) / std::pow(1.6 * pixels_per_voxel, 2);
        if (!(exact > 0)) continue;
        errors.anchored = std::max(errors.anchored, std::abs(evaluate(near, x, y) - exact));
        errors.absolute = std::max(errors.absolute, std::abs(evaluate(away, x + far, y + far) - exact));
      }
  }
  return errors;
}

/// Largest error of red and opacity, in 0..1, after `slices` slices of the same opacity.
inline double composite_error(int slices, double opacity) {
  const Footprint footprint = footprint_of_scale(20.0);
  RegionPainter painter(0, 0, 1, 1);
  painter.begin_frame(footprint);
  // At its centre a kernel's weight is exactly `weight`.
  const Splat splat = make_splat(footprint, {0, 0, 0, 0},
                                 {32768, 16384, 65535, static_cast<float>(opacity / footprint.weight)});
  double colour = 0, transmittance = 1;
  const double a = double(splat.opacity), c = a * double(splat.red) / 65535;
  for (int k = 0; k < slices; ++k) {
    painter.draw({&splat, 1});
    painter.composite();
    colour += transmittance * c;
    transmittance *= 1 - a;
  }
  std::array<float, 4> pixel{};
  painter.read_tile(pixel);
  return std::max(std::abs(double(pixel[0]) - colour), std::abs(double(pixel[3]) - (1 - transmittance)));
}

/// The bounds of the tests.
inline double drift_bound(int width) { return 4 * std::ldexp(2.0 * width, -52); }
inline constexpr double quadratic_bound = 1e-6;
inline double composite_bound(int slices) { return slices * std::ldexp(1.0, -24); }

}  // namespace ringsplat::test

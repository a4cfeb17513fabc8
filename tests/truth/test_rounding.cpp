// The renderer's three roundings, each measured alone against size.
#include <fmt/format.h>

#include <random>

#include "ringsplat/splat/encode.hpp"
#include "ringsplat/splat/region_painter.hpp"
#include "ringsplat/view/slice_dda.hpp"
#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

TEST_CASE("the DDA's drift: pixels, against the row's length") {
  // Each position is a row start plus a product rounded once, so its error is that of two roundings, whatever
  // the row's length: 2⁻⁵² of the largest coordinate. A running sum, beside it, drifts with the length.
  for (const int width : {64, 512, 4096, 32768}) {
    const LatticeFrame lattice{{width, 8, 8}, glm::dvec3(1.0), glm::dvec3(0.0), glm::dmat3(1.0)};
    const ViewTransform view =
        make_view({.azimuth = 17, .elevation = 13, .roll = 5, .zoom = 1}, lattice, 2 * width, 2 * width);
    SliceDda dda(view, Axis::z, width);
    double drift = 0, running_drift = 0;
    for (int row = 0; row < 8; ++row) {
      dda.begin_row(3, row);
      glm::dvec3 running = view.project({0, row, 3});
      for (int u = 0; u < width; ++u, running += view.linear[0])
        for (int k = 0; k < 2; ++k) {
          const auto exact = static_cast<long double>(view.linear[0][k]) * u +
                             static_cast<long double>(view.linear[1][k]) * row +
                             static_cast<long double>(view.linear[2][k]) * 3 +
                             static_cast<long double>(view.offset[k]);
          drift = std::max(
              drift, double(std::abs(exact - static_cast<long double>(dda.position(std::uint32_t(u))[k]))));
          running_drift =
              std::max(running_drift, double(std::abs(exact - static_cast<long double>(running[k]))));
        }
    }
    UNSCOPED_INFO(
        fmt::format("row of {}: {:.2g} pixels, as a running sum {:.2g}", width, drift, running_drift));
    CHECK(drift < 4 * std::ldexp(2.0 * width, -52));
    CHECK(running_drift < width * std::ldexp(2.0 * width, -53));
  }
}

namespace {

/// Largest error of Q over the kernel's pixels when the quadratic is evaluated in float32 with its origin
/// `from_centre` pixels from the kernel's centre: as coefficients A … F of absolute pixels would be.
struct QuadraticErrors {
  double anchored, absolute;
};
QuadraticErrors quadratic_errors(double pixels_per_voxel, double far) {
  ViewTransform view;
  view.linear = glm::dmat3(pixels_per_voxel);
  const Footprint footprint = make_footprint(view, Axis::z, 1.6);
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

}  // namespace

TEST_CASE("the quadratic's cancellation: Q, against the distance of its origin and the kernel's size") {
  // From the splat's own anchor the terms are a few units at most, so Q is off by a few 2⁻²⁴ whatever the
  // picture's or the kernel's size. From a far origin they grow with the square of the distance over the
  // kernel's width, and cancel.
  for (const double scale : {1.0, 4.0, 32.0}) {
    for (const double far : {128.0, 1024.0, 16384.0}) {
      const auto errors = quadratic_errors(scale, far);
      UNSCOPED_INFO(fmt::format("{} pixels a voxel, {} pixels away: {:.2g} anchored, {:.2g} absolute", scale,
                                far, errors.anchored, errors.absolute));
      CHECK(errors.anchored < 1e-6);
      CHECK(errors.absolute < 4 * std::ldexp(std::pow(far / (1.6 * scale) + 1, 2), -22));
      if (scale == 1.0 && far == 16384.0)
        CHECK(errors.absolute > 1);  // no digit is left: the instrument sees it
    }
  }
}

TEST_CASE("the composite's rounding: levels, against the number of slices") {
  // Each slice rounds the transmittance and the colour once: at most 2⁻²⁴ of them a slice, or n · 2⁻²⁴ after
  // n (Higham 2002, section 4.2); sums of like sign rounded to nearest do far better.
  const Footprint footprint = [] {
    ViewTransform view;
    view.linear = glm::dmat3(20.0);
    return make_footprint(view, Axis::z, 1.6);
  }();
  double before = 0;
  for (const int slices : {64, 512, 4096})
    for (const double opacity : {1e-7, 1e-4, 0.005, 0.3}) {
      RegionPainter painter(0, 0, 1, 1);
      painter.begin_frame(footprint);
      // Drawn at the pixel's centre, a kernel's weight there is exactly `weight`.
      const Splat splat =
          make_splat(footprint, 0, 0, 0.5F, 0.25F, 1.0F, static_cast<float>(opacity / footprint.weight));
      double colour = 0, transmittance = 1;
      const double a = double(splat.opacity), c = a * double(splat.red) / 65535;
      for (int k = 0; k < slices; ++k) {
        painter.draw(0, 0, std::as_bytes(std::span(&splat, 1)));
        painter.composite();
        colour += transmittance * c;
        transmittance *= 1 - a;
      }
      std::array<float, 4> pixel{};
      painter.read_tile(pixel);
      const double error =
          std::max(std::abs(double(pixel[0]) - colour), std::abs(double(pixel[3]) - (1 - transmittance)));
      UNSCOPED_INFO(fmt::format("{} slices of {}: {:.2g} levels", slices, opacity, 255 * error));
      CHECK(error < slices * std::ldexp(1.0, -24));
      before = std::max(before, error);
    }
  CHECK(before < 1.3e-4);
}

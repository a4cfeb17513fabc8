// Orders of convergence (Etiene et al. 2014): a truth with an error converges to the wrong picture, or at the
// wrong rate.
#include <fmt/format.h>

#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Camera oblique{.azimuth = 31, .elevation = 17, .roll = 9, .zoom = 1.2};

double blob(double x, double y, double z) {
  const double dx = x - 0.47, dy = y - 0.52, dz = z - 0.5;
  return std::exp(-(dx * dx + dy * dy + dz * dz) / (2 * 0.12 * 0.12));
}
double two_blobs(double x, double y, double z) {
  const double dx = x - 0.65, dy = y - 0.4, dz = z - 0.55;
  return 0.7 * blob(x, y, z) + 0.3 * std::exp(-(dx * dx + dy * dy + dz * dz) / (2 * 0.09 * 0.09));
}
/// Marschner and Lobb's signal with f_M = 2, which the coarsest grid here resolves.
double slow_marschner_lobb(double x, double y, double z) {
  const double r = std::hypot(2 * x - 1, 2 * y - 1), ring = std::cos(4 * M_PI * std::cos(M_PI * r / 2));
  return (1 - std::sin(M_PI * (2 * z - 1) / 2) + 0.25 * (1 + ring)) / 2.5;
}

/// RMS difference between the field truth and the formula's for n³ voxels. The opacity per voxel follows the
/// voxel's size, so that all grids show the same object.
double rms_error(Field field, int n, double depth_of_cube, bool jump) {
  TransferFunction tf = jump ? constant_opacity(-std::expm1(-depth_of_cube / n), 0.5)
                             : linear_extinction(depth_of_cube / n, 1.3);
  const FrameSpec spec = plain_spec(tf, 64, oblique);
  const Volume volume = sample_field(n, field);
  const auto scene = scene_of(volume, spec);
  const auto pixels = random_pixels(64, 64, 150, 1);
  const auto sampled = truth::field_truth(scene, pixels, 1e-8),
             formula = truth::analytic_truth(scene, field, 1.0, pixels, 1e-8);
  double sum = 0;
  for (std::size_t p = 0; p < pixels.size(); ++p) sum += std::pow(sampled[p].w - formula[p].w, 2);
  return std::sqrt(sum / double(pixels.size()));
}

/// The order of the last doubling. Checks that every refinement helps.
double order(const std::function<double(int)>& error, std::initializer_list<int> grids) {
  double before = 0, here = 0;
  double last_ratio = 0;
  int n_before = 0;
  std::string row;
  for (const int n : grids) {
    before = std::exchange(here, error(n));
    if (n_before > 0) {
      CHECK(here < before);
      last_ratio = std::log(before / here) / std::log(double(n) / n_before);
    }
    row += fmt::format(" {}:{:.3g}", n, here);
    n_before = n;
  }
  UNSCOPED_INFO("errors" << row << ", order " << last_ratio);
  return last_ratio;
}

}  // namespace

TEST_CASE("the field's truth converges to the formula's with the square of the voxel: smooth fields") {
  const struct {
    const char* name;
    Field field;
  } scenes[] = {
      {"a Gaussian", blob}, {"two Gaussians", two_blobs}, {"Marschner-Lobb, f_M = 2", slow_marschner_lobb}};
  for (const auto& scene : scenes) {
    INFO(scene.name);
    // Trilinear interpolation is of second order: the error of a smooth field falls fourfold when the grid is
    // doubled.
    const double found =
        order([&](int n) { return rms_error(scene.field, n, 4.0, false); }, {12, 24, 48, 96});
    CHECK(found > 1.85);
    CHECK(found < 2.2);
  }
}

TEST_CASE("the field's truth converges to a ball with a sharp surface") {
  // The surface is off by O(h²), and so are chords, except near the silhouette, where they go with its root.
  // The number of grazing rays differs from grid to grid, so the order is 2 only roughly.
  const double found =
      order([&](int n) { return rms_error(synth_field("ball"), n, 4.0, true); }, {12, 24, 48, 96});
  CHECK(found > 1.4);
  CHECK(found < 2.6);
}

TEST_CASE("the splatted image of a smooth field converges to the formula's") {
  const auto error = [](int n) {
    const FrameSpec spec = plain_spec(linear_extinction(4.0 / n, 1.3), 64, oblique);
    const Volume volume = sample_field(n, blob, ScalarType::float32);
    const auto scene = scene_of(volume, spec);
    const auto pixels = truth::all_pixels(64, 64);
    const Image formula = truth::to_image(64, 64, truth::analytic_truth(scene, blob, 1.0, pixels));
    return truth::compare(rendered(volume, spec), formula).total.rmse;
  };
  // The kernel's blur, a fixed share of a voxel, is an error of second order. On fine grids its ripple takes
  // over, which more slices average away.
  const double found = order(error, {12, 24, 48});
  CHECK(found > 1.8);
  CHECK(error(96) < 0.6 * error(48));
}

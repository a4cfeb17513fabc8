#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int size = 25;
const Camera oblique{.azimuth = 31, .elevation = 17, .roll = 9, .zoom = 1.1};

/// The analytic truth of a field on an anisotropic box against a closed form of the optical depth.
double largest_error(Field field, const TransferFunction& tf,
                     const std::function<double(const truth::CubeRay&)>& depth, double tolerance = 1e-6) {
  truth::Scene scene;
  scene.grid = make_grid({20, 30, 10}, ScalarType::float64, {1.0, 0.8, 2.5});
  scene.frame.shown.transfer_function = tf;
  scene.frame.shown.camera = oblique;
  scene.frame.shown.width = scene.frame.shown.height = size;
  scene.frame.shown.shading = Shading::none;
  const auto pixels = truth::all_pixels(size, size);
  const auto colours = truth::analytic_truth(scene, field, 1.0, pixels, tolerance);
  double largest = 0, deepest = 0;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const double opacity = -std::expm1(-depth(truth::cube_ray(scene, pixels[p])));
    largest = std::max(largest, std::abs(colours[p].w - opacity));
    deepest = std::max(deepest, opacity);
  }
  REQUIRE(deepest > 0.3);
  return largest;
}

double one_blob(double x, double y, double z) {
  const double dx = x - 0.45, dy = y - 0.55, dz = z - 0.5;
  return std::exp(-(dx * dx + dy * dy + dz * dz) / (2 * 0.15 * 0.15));
}

}  // namespace

TEST_CASE("a slab, a box and a ball of constant density have the closed form's opacity") {
  const TransferFunction jump = constant_opacity(0.1, 0.5);
  const double sigma = -std::log(0.9);
  CHECK(largest_error(synth_field("constant"), jump, [&](const truth::CubeRay& ray) {
          return sigma * truth::length_in_box(ray, glm::dvec3(0.0), glm::dvec3(1.0));
        }) < 1e-6);
  CHECK(largest_error(synth_field("slab"), jump, [&](const truth::CubeRay& ray) {
          return sigma * truth::length_in_box(ray, {0, 0, 0.25}, {1, 1, 0.75});
        }) < 1e-6);
  CHECK(largest_error(synth_field("box"), jump, [&](const truth::CubeRay& ray) {
          return sigma * truth::length_in_box(ray, glm::dvec3(0.25), glm::dvec3(0.75));
        }) < 1e-6);
  // The field 1 − 2r is above one half within a quarter of the cube; a chord shorter than 1/512 of the ray
  // may be missed.
  CHECK(largest_error(synth_field("ball"), jump, [&](const truth::CubeRay& ray) {
          return sigma * truth::length_in_ball(ray, glm::dvec3(0.5), 0.25);
        }) < 1e-6);
}

TEST_CASE("a Gaussian of one colour has the closed form's opacity") {
  const double kappa = 0.12;
  // The transfer function's 2048 straight pieces leave κ²/8 · 2048⁻² of the extinction.
  CHECK(largest_error(one_blob, linear_extinction(kappa, 1.0), [&](const truth::CubeRay& ray) {
          return kappa * truth::integral_of_gaussian(ray, {0.45, 0.55, 0.5}, 0.15);
        }) < 1e-6);
}

TEST_CASE("lengths along a ray are those of geometry") {
  const truth::CubeRay ray{{0.5, 0.5, -3.0}, {0, 0, 0.1}};
  CHECK(truth::length_in_box(ray, glm::dvec3(0.25), glm::dvec3(0.75)) == Approx(5));
  CHECK(truth::length_in_ball(ray, glm::dvec3(0.5), 0.25) == Approx(5));
  CHECK(truth::length_in_ball(ray, {0.5, 0.9, 0.5}, 0.25) == 0.0);
  CHECK(truth::length_in_box({{2.0, 0.5, 0.5}, {0, 0, 0.1}}, glm::dvec3(0.0), glm::dvec3(1.0)) == 0.0);
  CHECK(truth::integral_of_gaussian(ray, glm::dvec3(0.5), 0.01) == Approx(0.01 / 0.1 * std::sqrt(2 * M_PI)));
}

TEST_CASE("Marschner and Lobb's signal: the formula's truth keeps its tolerance") {
  truth::Scene scene;
  scene.grid = make_grid({32, 32, 32}, ScalarType::float64);
  scene.frame.shown.transfer_function = ramp(0.3, 0.8, 0.4);
  scene.frame.shown.camera = oblique;
  scene.frame.shown.width = scene.frame.shown.height = 12;
  const auto pixels = truth::all_pixels(12, 12);
  const auto fine = truth::analytic_truth(scene, synth_field("marschner-lobb"), 1.0, pixels, 1e-10);
  const auto usual = truth::analytic_truth(scene, synth_field("marschner-lobb"), 1.0, pixels, 1e-6);
  CHECK(largest_difference(fine, usual) < 1e-6);
}

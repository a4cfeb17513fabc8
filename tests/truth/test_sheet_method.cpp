#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "ringsplat/base/error.hpp"
#include "study/error_budget.hpp"
#include "support/catch.hpp"
#include "truth/scene.hpp"
#include "truth/slab_integral.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Camera oblique{.azimuth = 31, .elevation = 17, .roll = 9, .zoom = 1.1};
/// Each axis from both sides, with something of the other two.
const std::vector<Camera> sides{
    {.azimuth = 12, .elevation = 9},  {.azimuth = 190, .elevation = -14},
    {.azimuth = 80, .elevation = 5},  {.azimuth = -100, .elevation = 20, .roll = 50},
    {.azimuth = 20, .elevation = 70}, {.azimuth = 130, .elevation = -65}};

FrameSpec sheets_spec(const TransferFunction& tf, int size, const Camera& camera, int slabs,
                      int light_points = 2) {
  FrameSpec spec = plain_spec(tf, size, camera);
  spec.how = Sheets{.slabs = slabs, .light_points = light_points};
  return spec;
}

FrameSpec lit(FrameSpec spec) {
  spec.shown.shading = Shading::phong;
  return spec;
}

TransferFunction steep() {
  TransferFunction tf;
  tf.colours = {{0.0, {1, 0.1, 0.0}}, {0.35, {0.2, 0.9, 0.1}}, {0.5, {0.3, 0.2, 1}}, {1.0, {1, 1, 1}}};
  tf.opacities = {{0.3, 0.0}, {0.4, 0.35}, {0.45, 0.02}, {0.7, 0.3}};
  return tf;
}

/// RMS over all channels of the difference from the field's truth, in values of 0..1.
double error_to_field(const Volume& volume, const FrameSpec& spec, std::size_t pixels = 400) {
  const auto scene = scene_of(volume, spec);
  const auto some = random_pixels(spec.shown.width, spec.shown.height, pixels, 5);
  const auto sheets = truth::method_truth(scene, some), field = truth::field_truth(scene, some, 1e-8);
  double sum = 0;
  for (std::size_t p = 0; p < some.size(); ++p) sum += glm::dot(sheets[p] - field[p], sheets[p] - field[p]);
  return std::sqrt(sum / double(4 * some.size()));
}

/// Largest difference from 1 − (1 − opacity)^length in the box, for a white medium of values 1.
double box_error(const Volume& volume, const FrameSpec& spec, double opacity) {
  const auto scene = scene_of(volume, spec);
  const auto pixels = truth::all_pixels(spec.shown.width, spec.shown.height);
  const auto colours = truth::method_truth(scene, pixels);
  double largest = 0;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const double length =
        truth::length_in_box(truth::cube_ray(scene, pixels[p]), glm::dvec3(0.0), glm::dvec3(1.0));
    const double expected = 1 - std::pow(1 - opacity, length);
    largest = std::max({largest, std::abs(colours[p].w - expected), std::abs(colours[p].y - expected)});
  }
  return largest;
}

/// `pieces` pieces of constant value, front to back.
truth::SlabIntegral brute_force(const truth::TransferCurve& curve, double front, double back, double length) {
  constexpr int pieces = 100000;
  double transmittance = 1, place = 0, square = 0;
  glm::dvec3 colour(0.0);
  for (int i = 0; i < pieces; ++i) {
    const double t = (i + 0.5) / pieces;
    const auto sample = curve.at(front + t * (back - front));
    const double seen = transmittance * (1 - std::pow(1 - sample.opacity, length / pieces));
    colour += seen * sample.colour;
    place += seen * t;
    square += seen * t * t;
    transmittance -= seen;
  }
  const double opacity = 1 - transmittance;
  return {opacity, colour / opacity, place / opacity,
          std::sqrt(std::max(0.0, square / opacity - std::pow(place / opacity, 2)))};
}

}  // namespace

TEST_CASE("a slab's integral is that of a hundred thousand pieces") {
  TransferFunction tf = steep();
  tf.opacities.insert(tf.opacities.end(), {{0.8, 0.3}, {0.8, 0.9}, {0.85, 0.1}, {0.9, 0.999999}});
  const truth::TransferCurve curve(tf);
  const std::pair<double, double> ends[] = {{0.1, 0.95},  {0.95, 0.1}, {0.31, 0.34},
                                            {0.44, 0.39}, {0.6, 0.6},  {0.79, 0.81},
                                            {0.81, 0.79}, {0.9, 0.2},  {0.2, 0.305}};
  for (const auto& [front, back] : ends)
    for (const double length : {0.01, 0.5, 1.7, 12.0}) {
      INFO(fmt::format("{} to {}, length {}", front, back, length));
      const auto exact = truth::integrate_slab(curve, front, back, length);
      const auto pieces = brute_force(curve, front, back, length);
      CHECK(exact.opacity == Approx(pieces.opacity).epsilon(5e-5));
      for (int c = 0; c < 3; ++c) CHECK(exact.colour[c] == Approx(pieces.colour[c]).margin(5e-5));
      CHECK(exact.centroid == Approx(pieces.centroid).margin(5e-5));
      CHECK(exact.spread == Approx(pieces.spread).margin(5e-5));
    }
}

TEST_CASE("a slab of one value has the closed forms of a uniform medium, however faint or deep") {
  for (const double opacity : {1e-12, 1e-6, 0.01, 0.5, 0.999}) {
    const truth::TransferCurve curve(constant_opacity(opacity));
    for (const double length : {0.25, 1.0, 30.0}) {
      INFO(fmt::format("opacity {}, length {}", opacity, length));
      const auto slab = truth::integrate_slab(curve, 0.25, 0.75, length);
      const double depth = -length * std::log1p(-opacity), seen = -std::expm1(-depth);
      CHECK(slab.opacity == Approx(seen).epsilon(1e-12));
      if (depth < 1e-3) {
        CHECK(slab.centroid == Approx(0.5 - depth / 12).epsilon(1e-6));
        CHECK(slab.spread == Approx(std::sqrt(1.0 / 12)).epsilon(1e-6));
      } else {
        const double mean = 1 / depth - std::exp(-depth) / seen;
        const double square = 2 / (depth * depth) - std::exp(-depth) * (1 + 2 / depth) / seen;
        CHECK(slab.centroid == Approx(mean).epsilon(1e-9));
        CHECK(slab.spread == Approx(std::sqrt(square - mean * mean)).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("an opaque slab shows the colour at its front, and hides what is behind the opaque value") {
  TransferFunction tf = constant_opacity(1);
  tf.colours = {{0.0, {1, 0, 0}}, {1.0, {0, 0, 1}}};
  auto slab = truth::integrate_slab(truth::TransferCurve(tf), 0.0, 1.0, 1.0);
  CHECK(slab.opacity == 1.0);
  CHECK(slab.colour == glm::dvec3(1, 0, 0));
  CHECK(slab.centroid == 0.0);
  CHECK(slab.spread == 0.0);
  tf.opacities = {{0.5, 0.0}, {0.5, 1.0}};  // nothing before the middle
  tf.colours = {{0.0, {0, 0, 0}}, {0.5, {1, 0, 0}}, {1.0, {0, 0, 1}}};
  slab = truth::integrate_slab(truth::TransferCurve(tf), 0.0, 1.0, 1.0);
  CHECK(slab.opacity == 1.0);
  CHECK(slab.colour.x == Approx(1).margin(1e-9));
  CHECK(slab.centroid == Approx(0.5).margin(1e-9));
  CHECK(slab.spread == Approx(0.0).margin(1e-6));
}

TEST_CASE("the error of sheets against the field falls to a fourth and further when slabs are doubled") {
  for (const Camera& camera : {oblique, Camera{.azimuth = 70, .elevation = 35}}) {
    const Volume volume = sample_field(24, lumps_in_ball);
    double error[3];
    for (int i = 0; i < 3; ++i) error[i] = error_to_field(volume, sheets_spec(steep(), 64, camera, 1 << i));
    INFO(fmt::format("{:.3g} {:.3g} {:.3g}", error[0], error[1], error[2]));
    CHECK(error[0] > 1e-4);
    CHECK(error[0] / error[1] > 5);
    CHECK(error[1] / error[2] > 4);
  }
}

TEST_CASE("sheets of a uniform volume are a box of its voxels' faces") {
  const struct {
    glm::ivec3 dims;
    glm::dvec3 spacing;
  } grids[] = {{{9, 9, 9}, glm::dvec3(1.0)},
               {{9, 12, 7}, {1.0, 0.5, 2.0}},
               {{9, 1, 7}, glm::dvec3(1.0)},
               {{1, 1, 1}, glm::dvec3(1.0)},
               {{12, 12, 3}, {1, 1, 10}}};
  for (const auto& [dims, spacing] : grids)
    for (const int slabs : {1, 2, 3, 4}) {
      const Volume volume = make_volume(
          dims, ScalarType::uint8, [](int, int, int) { return 1; }, spacing);
      auto cameras = sides;
      cameras.insert(cameras.end(), {{}, {.azimuth = 90}, {.elevation = 90}, oblique});
      for (const Camera& camera : cameras) {
        CAPTURE(dims.x, dims.y, dims.z, slabs, camera.azimuth, camera.elevation);
        CHECK(box_error(volume, sheets_spec(constant_opacity(0.2), 24, camera, slabs), 0.2) < 1e-9);
      }
    }
}

TEST_CASE("without opacity correction a slice is one unit long whatever the view") {
  const Volume volume = make_volume({12, 12, 12}, ScalarType::uint8, [](int, int, int) { return 1; });
  FrameSpec spec = sheets_spec(constant_opacity(0.1), 33, {.azimuth = 30, .zoom = 3}, 3);
  spec.shown.opacity_correction = false;
  CHECK(method_at(scene_of(volume, spec), {16, 16}).w == Approx(1 - std::pow(0.9, 12)).epsilon(1e-12));
}

TEST_CASE("all three axes, walked either way, agree with the field") {
  const Volume volume = sample_field(24, lumps_in_ball);
  const Volume anisotropic = make_volume(
      {30, 30, 6}, ScalarType::float64,
      [](int x, int y, int z) { return lumps_in_ball((x + 0.5) / 30, (y + 0.5) / 30, (z + 0.5) / 6); },
      {1, 1, 5});
  for (const Camera& camera : sides) {
    INFO(fmt::format("azimuth {}, elevation {}", camera.azimuth, camera.elevation));
    CHECK(error_to_field(volume, sheets_spec(steep(), 48, camera, 2)) < 0.001);
    CHECK(error_to_field(volume, lit(sheets_spec(steep(), 48, camera, 2))) < 0.004);
    CHECK(error_to_field(anisotropic, sheets_spec(steep(), 48, camera, 4)) < 0.004);
  }
}

TEST_CASE("two light points are nearer to the field than one") {
  const Volume volume = sample_field(24, lumps_in_ball);
  const double one = error_to_field(volume, lit(sheets_spec(steep(), 48, oblique, 2, 1))),
               two = error_to_field(volume, lit(sheets_spec(steep(), 48, oblique, 2, 2)));
  INFO(fmt::format("one {:.3g}, two {:.3g}", one, two));
  CHECK(two < 0.8 * one);
}

TEST_CASE("differences at the volume's faces are one-sided, so that a ramp is lit evenly") {
  const Volume volume =
      make_volume({7, 8, 9}, ScalarType::float64, [](int x, int y, int z) { return 3 * x + 2 * y + z; });
  for (const Camera& camera : sides)
    for (const int light_points : {1, 2}) {
      const auto spec = lit(sheets_spec(constant_opacity(0.4), 24, camera, 2, light_points));
      const auto scene = scene_of(volume, spec);
      const ViewTransform view = make_view(camera, {.dims = {7, 8, 9}}, 24, 24);
      const glm::dvec3 expected =
          truth::Phong(scene, view).shade(glm::dvec3(1.0), {-3, -2, -1}, view.to_viewer);
      double largest = 0;
      for (const auto& colour : truth::method_truth(scene, truth::all_pixels(24, 24)))
        largest = std::max(largest, std::abs(colour.x - colour.w * expected.x));
      INFO(fmt::format("azimuth {}, {} light points", camera.azimuth, light_points));
      CHECK(largest < 1e-12);
    }
}

TEST_CASE("no point at which a slab is lit lies beyond its sheets") {
  // One slab seen from above, from 1 at its front to 0, with an opaque layer near either end: one hides most
  // of the other, and centroid and spread reach beyond its end. There the gradient is perpendicular to the
  // light.
  for (const bool at_front : {true, false}) {
    const double leaning_front = at_front ? -1 : 0.5, leaning_back = at_front ? 0.5 : -1;
    const Volume volume = make_volume({3, 3, 2}, ScalarType::float64, [&](int x, int, int z) {
      return z + (x - 1) * (z == 1 ? leaning_front : leaning_back);
    });
    TransferFunction tf = constant_opacity(0);
    const double front = at_front ? 1 - 1e-9 : 0.95, back = at_front ? 0.999 : 1 - 1e-12;
    tf.opacities = {{0.01, 0.0}, {0.01, back},  {0.06, back},  {0.06, 0.0},
                    {0.94, 0.0}, {0.94, front}, {0.99, front}, {0.99, 0.0}};
    FrameSpec spec = lit(sheets_spec(tf, 33, {.elevation = 90}, 1, 2));
    spec.shown.material = {.ambient = 0, .diffuse = 1, .specular = 0};
    spec.shown.light = {1, 0, 1};
    const auto slab = truth::integrate_slab(truth::TransferCurve(tf), 1, 0, 1);
    REQUIRE((at_front ? slab.centroid - slab.spread < -0.05 : slab.centroid + slab.spread > 1.05));
    const auto light = [&](double t) {
      const double leaning = leaning_front + t * (leaning_back - leaning_front);
      return std::abs(leaning + 1) / std::sqrt(2 * (leaning * leaning + 1));
    };
    const double inner = at_front ? slab.centroid + slab.spread : slab.centroid - slab.spread;
    const auto colour = method_at(scene_of(volume, spec), {16, 16});
    CHECK(colour.w == Approx(slab.opacity).epsilon(1e-9));
    CHECK(colour.x == Approx(slab.opacity * 0.5 * light(inner)).epsilon(1e-6));
  }
}

TEST_CASE("slabs beside a voxel that is not a number are empty") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  // Seen along y. A missing slice costs the slabs on both sides, or at the face one slice and a half.
  for (const auto& [slice, lost] : {std::pair{4, 2.0}, {0, 1.5}, {7, 1.5}})
    for (const int slabs : {1, 2, 3}) {
      const Volume volume = make_volume({9, 8, 9}, ScalarType::float32,
                                        [&, s = slice](int, int y, int) { return y == s ? nan : 1.0; });
      INFO(fmt::format("slice {}, {} slabs", slice, slabs));
      const auto scene = scene_of(volume, sheets_spec(constant_opacity(0.3), 9, {.zoom = 2}, slabs));
      CHECK(method_at(scene, {4, 4}).w == Approx(1 - std::pow(0.7, 8 - lost)).epsilon(1e-9));
    }
  const Volume missing = make_volume({8, 8, 8}, ScalarType::float32, [&](int, int, int) { return nan; });
  CHECK(brightest(method_image(missing, sheets_spec(constant_opacity(0.3), 9, oblique, 2))) == 0.0F);
}

TEST_CASE("infinite voxels are drawn as values beyond the transfer function's ends") {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto spec = sheets_spec(constant_opacity(0.5, 0.5), 24, oblique, 2);
  const auto image_of = [&](double v) {
    return method_image(make_volume({8, 8, 8}, ScalarType::float32, [&](int, int, int) { return v; }), spec);
  };
  CHECK(largest_difference(image_of(infinity), image_of(1)) == 0.0);
  CHECK(brightest(image_of(-infinity)) == 0.0F);
}

TEST_CASE("a frame of sheets is measured against the truth of sheets") {
  const Volume volume = sample_field(12, lumps_in_ball);
  const auto spec = sheets_spec(steep(), 24, oblique, 1);
  auto scene = scene_of(volume, spec);
  const auto pixels = truth::all_pixels(24, 24);
  CHECK(app::evaluate(scene, {.truth = app::TruthKind::method}, pixels) ==
        truth::sheet_method_truth(scene, pixels));
  CHECK(pixels_of(truth::method_bounds(scene)) == pixels_of(truth::field_bounds(scene)));
  scene.frame.how = Splats{};
  CHECK(app::evaluate(scene, {.truth = app::TruthKind::method}, pixels) ==
        truth::splat_method_truth(scene, pixels));
}

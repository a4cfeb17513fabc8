// Voxels of unlike spacings and lattices that are not orthogonal, against closed forms in world coordinates.
#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr double degrees = M_PI / 180;

/// z slices shifted against each other, as by a tilted gantry.
glm::dmat3 oblique_direction() {
  glm::dmat3 direction(1.0);
  direction[2] = glm::normalize(glm::dvec3(0.3, -0.4, 1.0));
  return direction;
}

Volume even_volume(glm::ivec3 dims, glm::dvec3 spacing, const glm::dmat3& direction = glm::dmat3(1.0)) {
  Volume volume = make_volume(
      dims, ScalarType::uint8, [](int, int, int) { return 1; }, spacing);
  volume.grid.direction = direction;
  return volume;
}

/// A camera that looks at the slices of `axis` from `tilt` degrees beside their normal.
Camera tilted(Axis axis, double tilt) {
  if (axis == Axis::z) return {.elevation = 90 - tilt, .zoom = 1.5};
  return {.azimuth = (axis == Axis::x ? 90 : 0) + tilt, .zoom = 1.5};
}

/// Of the unit cube.
const glm::dvec3 slopes{2.0, 3.0, -4.0};
double sloping(double x, double y, double z) { return 50 + glm::dot(slopes, glm::dvec3(x, y, z)); }

double constant(double, double, double) { return 1; }

const truth::Pixel middle{16, 16};

/// The formula of a constant medium at the middle pixel.
double formula_opacity(const truth::Scene& scene) {
  return truth::analytic_truth(scene, constant, 1.0, std::vector{middle}).front().w;
}

}  // namespace

TEST_CASE("a slab is as opaque as it is thick in smallest spacings, over the cosine") {
  const glm::dvec3 spacing{1.0, 0.5, 2.0};
  for (const Axis axis : all_axes)
    for (const double tilt : {0.0, 30.0}) {
      const int k = int(axis);
      glm::ivec3 dims(31);
      dims[k] = 2;
      const FrameSpec spec = plain_spec(constant_opacity(0.2), 33, tilted(axis, tilt));
      const auto scene = scene_of(even_volume(dims, spacing), spec);
      const double units = 2 * spacing[k] / 0.5 / std::cos(tilt * degrees);
      CAPTURE(name(axis), tilt);
      const double opacity = 1 - std::pow(0.8, units);
      CHECK(field_at(scene, middle).w == Approx(opacity).epsilon(1e-9));
      CHECK(formula_opacity(scene) == Approx(opacity).epsilon(1e-6));
    }
}

TEST_CASE("slices that are shifted against each other lie nearer together than their spacing") {
  const glm::dmat3 direction = oblique_direction();
  const glm::dvec3 spacing{1.0, 0.8, 2.0};
  for (const double tilt : {0.0, 25.0}) {
    FrameSpec spec = plain_spec(constant_opacity(0.2), 33, tilted(Axis::z, tilt));
    spec.as<Splats>().kernel_radius = 2.5;
    const Volume volume = even_volume({31, 37, 3}, spacing, direction);
    const auto scene = scene_of(volume, spec);
    const double units = 3 * spacing.z * direction[2].z / 0.8 / std::cos(tilt * degrees),
                 opacity = 1 - std::pow(0.8, units);
    INFO("tilted by " << tilt);
    CHECK(field_at(scene, middle).w == Approx(opacity).epsilon(1e-9));
    CHECK(formula_opacity(scene) == Approx(opacity).epsilon(1e-6));
    // Kernels of this radius ripple by 0.53 % at most, slices of opacity 0.4 thus by 0.3 % together; slices
    // that are as far apart as their spacing would be 4 % more opaque.
    const double method = method_at(scene, middle).w;
    CHECK(method == Approx(opacity).epsilon(3e-3));
    CHECK(rendered(volume, spec).pixel(16, 16)[3] == Approx(method).epsilon(2e-5));
  }
}

TEST_CASE("oblique lattices: the renderer agrees with the method's truth") {
  Volume volume = make_volume({24, 20, 22}, ScalarType::float32, [](int x, int y, int z) {
    return 0.5 + 0.5 * std::sin(0.4 * x + 0.2 * y) * std::cos(0.3 * y - 0.5 * z);
  });
  volume.grid.spacing = {1.0, 0.7, 1.4};
  volume.grid.direction = oblique_direction();
  for (const Camera& camera :
       {Camera{.azimuth = 20, .elevation = 15, .roll = 5}, Camera{.azimuth = 100, .elevation = -10},
        Camera{.azimuth = 20, .elevation = 70}})
    for (const Shading shading : {Shading::none, Shading::phong}) {
      FrameSpec spec = plain_spec(ramp(0.2, 1.0, 0.35), 56, camera);
      spec.shown.shading = shading;
      INFO(fmt::format("azimuth {}, elevation {}", camera.azimuth, camera.elevation));
      REQUIRE(brightest(rendered(volume, spec)) > 0.1F);
      CHECK(numerical_error(volume, spec) < 1e-5);
    }
}

TEST_CASE("a field that is linear in the world has one normal everywhere, at the volume's faces too") {
  // Seen along +y: right is x, up is z, towards the viewer is −y.
  const glm::dvec3 light = glm::normalize(glm::dvec3(-0.4, -0.7, 0.6));
  const glm::ivec3 dims{7, 6, 5};
  for (const glm::dmat3& direction : {glm::dmat3(1.0), oblique_direction()})
    for (const glm::dvec3& spacing : {glm::dvec3(1.0, 0.4, 2.5), glm::dvec3(2.5, 1.0, 0.4)}) {
      INFO(fmt::format("spacings {} {} {}", spacing.x, spacing.y, spacing.z));
      Volume volume = make_volume(
          dims, ScalarType::float64,
          [&](int x, int y, int z) {
            return sloping((x + 0.5) / dims.x, (y + 0.5) / dims.y, (z + 0.5) / dims.z);
          },
          spacing);
      volume.grid.direction = direction;
      // A step along each edge of the volume rises by its slope.
      const glm::dvec3 size = spacing * glm::dvec3(dims);
      const glm::dmat3 edges(direction[0] * size.x, direction[1] * size.y, direction[2] * size.z);
      const glm::dvec3 gradient = glm::inverse(glm::transpose(edges)) * slopes;
      for (int k = 0; k < 3; ++k) REQUIRE(glm::dot(gradient, edges[k]) == Approx(slopes[k]));

      FrameSpec spec = plain_spec(constant_opacity(0.3), 33);
      spec.shown.shading = Shading::phong;
      spec.shown.light = {-0.4, 0.6, 0.7};
      spec.shown.material = {.ambient = 0.2, .diffuse = 0.7, .specular = 0, .exponent = 1};
      const double brightness = 0.2 + 0.7 * std::abs(glm::dot(glm::normalize(gradient), light));
      const auto worst = [&](const std::vector<truth::Rgba>& colours) {
        double largest = 0;
        int seen = 0;
        for (const auto& colour : colours)
          if (colour.w > 1e-3) {
            largest = std::max(largest, std::abs(colour.x / colour.w - brightness));
            ++seen;
          }
        REQUIRE(seen > 50);
        return largest;
      };
      const auto scene = scene_of(volume, spec);
      const auto pixels = truth::all_pixels(33, 33);
      CHECK(worst(truth::field_truth(scene, pixels)) < 1e-6);
      CHECK(worst(truth::analytic_truth(scene, sloping, 1.0, pixels)) < 1e-6);
      CHECK(worst(truth::method_truth(scene, pixels)) < 1e-9);
      const Image image = rendered(volume, spec);
      std::vector<truth::Rgba> drawn;
      for (const auto& p : pixels) {
        const float* rgba = image.pixel(p.x, p.y);
        drawn.emplace_back(rgba[0], rgba[1], rgba[2], rgba[3]);
      }
      CHECK(worst(drawn) < 5e-3);  // normals of 16 bits lie a hundredth apart
    }
}

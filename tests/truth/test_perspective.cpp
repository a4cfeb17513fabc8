// Perspective views against closed forms whose rays are made here from the camera's definition.
#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "truth/scene.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int width = 30, height = 24;

/// From the eye, in world units; the direction has unit length.
struct EyeRay {
  glm::dvec3 eye, direction;
};

/// Of a grid with its axes along the world's and its first voxel at the origin.
EyeRay eye_ray(const Camera& camera, const Grid& grid, truth::Pixel pixel) {
  const double a = camera.azimuth * M_PI / 180, e = camera.elevation * M_PI / 180,
               slope = std::tan(camera.fov * M_PI / 360);
  const glm::dvec3 to_viewer{std::cos(e) * std::sin(a), -std::cos(e) * std::cos(a), std::sin(e)},
      right{std::cos(a), std::sin(a), 0},
      up{-std::sin(e) * std::sin(a), std::sin(e) * std::cos(a), std::cos(e)};
  const double radius = 0.5 * glm::length(grid.spacing * glm::dvec3(grid.dims)),
               distance = radius * (camera.distance > 0 ? camera.distance : 1 / slope),
               pixel_slope = slope / camera.zoom / (0.5 * std::min(width, height));
  const glm::dvec3 centre = 0.5 * grid.spacing * glm::dvec3(grid.dims - 1);
  return {centre + distance * to_viewer,
          glm::normalize(-to_viewer + pixel_slope * (pixel.x + 0.5 - 0.5 * width) * right -
                         pixel_slope * (pixel.y + 0.5 - 0.5 * height) * up)};
}

/// World length of the ray in the box of the voxels' faces.
double length_in_faces(const EyeRay& ray, const Grid& grid) {
  double enter = 0, leave = 1e300;
  for (int k = 0; k < 3; ++k) {
    const double low = -0.5 * grid.spacing[k], high = (grid.dims[k] - 0.5) * grid.spacing[k];
    const double a = (low - ray.eye[k]) / ray.direction[k], b = (high - ray.eye[k]) / ray.direction[k];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return std::max(0.0, leave - enter);
}

const std::vector<Camera> cameras{{.azimuth = 31, .elevation = 17, .fov = 40},
                                  {.azimuth = 200, .elevation = -60, .zoom = 1.3, .fov = 70},
                                  {.azimuth = 95, .elevation = 3, .zoom = 0.7, .fov = 40, .distance = 1.2},
                                  {.azimuth = -10, .elevation = 80, .fov = 5},
                                  {.azimuth = 45, .elevation = 35, .fov = 110, .distance = 1.01},
                                  {.azimuth = 3, .elevation = 2, .zoom = 12, .fov = 30, .distance = 50}};

std::string named(const Camera& c) {
  return fmt::format("azimuth {}, elevation {}, fov {}, distance {}", c.azimuth, c.elevation, c.fov,
                     c.distance);
}

FrameSpec perspective_spec(const TransferFunction& tf, const Camera& camera, int slabs = 2) {
  FrameSpec spec = plain_spec(tf, width, camera);
  spec.shown.height = height;
  spec.how = Sheets{.slabs = slabs};
  return spec;
}

using Truth = std::function<std::vector<truth::Rgba>(const truth::Scene&, std::span<const truth::Pixel>)>;
const std::vector<std::pair<const char*, Truth>> field_and_sheets{
    {"field", [](const auto& scene, auto pixels) { return truth::field_truth(scene, pixels); }},
    {"sheets", [](const auto& scene, auto pixels) { return truth::method_truth(scene, pixels); }}};

}  // namespace

TEST_CASE("a uniform box in perspective is as deep as its chords") {
  const struct {
    glm::ivec3 dims;
    glm::dvec3 spacing;
  } grids[] = {{{9, 9, 9}, glm::dvec3(1.0)}, {{9, 12, 7}, {1.0, 0.5, 2.0}}, {{8, 1, 8}, glm::dvec3(3.0)}};
  for (const auto& [dims, spacing] : grids)
    for (const Camera& camera : cameras) {
      const Volume volume = make_volume(
          dims, ScalarType::uint8, [](int, int, int) { return 1; }, spacing);
      const auto scene = scene_of(volume, perspective_spec(constant_opacity(0.2), camera, 3));
      const auto pixels = truth::all_pixels(width, height);
      const double unit = std::min({spacing.x, spacing.y, spacing.z});
      for (const auto& [name, truth] : field_and_sheets) {
        const auto colours = truth(scene, pixels);
        double largest = 0, deepest = 0;
        for (std::size_t p = 0; p < pixels.size(); ++p) {
          const double length = length_in_faces(eye_ray(camera, volume.grid, pixels[p]), volume.grid) / unit;
          deepest = std::max(deepest, length);
          largest = std::max(largest, std::abs(colours[p].w - (1 - std::pow(0.8, length))));
        }
        INFO(fmt::format("{} x {} x {}, {}: {}", dims.x, dims.y, dims.z, named(camera), name));
        CHECK(deepest > 0.5);
        CHECK(largest < 1e-9);
      }
    }
}

TEST_CASE("a ball in perspective is as deep as its chords") {
  constexpr int n = 16;
  const double ball_radius = 0.25 * n;  // where the formula is 1/2
  const Volume volume = sample_field(n, synth_field("ball"));
  for (const Camera& camera : cameras) {
    INFO(named(camera));
    const auto scene = scene_of(volume, perspective_spec(constant_opacity(0.2, 0.5), camera));
    const auto pixels = truth::all_pixels(width, height);
    const auto colours = truth::analytic_truth(scene, synth_field("ball"), 1.0, pixels);
    double largest = 0, deepest = 0;
    for (std::size_t p = 0; p < pixels.size(); ++p) {
      const EyeRay ray = eye_ray(camera, volume.grid, pixels[p]);
      const glm::dvec3 from = ray.eye - 0.5 * (n - 1);
      const glm::dvec3 nearest = from - glm::dot(from, ray.direction) * ray.direction;
      const double length =
          2 * std::sqrt(std::max(0.0, ball_radius * ball_radius - glm::dot(nearest, nearest)));
      deepest = std::max(deepest, length);
      largest = std::max(largest, std::abs(colours[p].w - (1 - std::pow(0.8, length))));
    }
    CHECK(deepest > ball_radius);
    CHECK(largest < 1e-5);
  }
}

TEST_CASE("light in perspective is reflected towards the eye") {
  // Values rise evenly, so all of a ray is lit alike.
  const auto value = [](int x, int y, int z) { return 3 * x + 2 * y + z; };
  const Volume volume = make_volume({7, 8, 9}, ScalarType::float64, value);
  for (const Camera& camera : cameras) {
    FrameSpec spec = perspective_spec(constant_opacity(0.4), camera);
    spec.shown.shading = Shading::phong;
    spec.shown.material.exponent = 2;  // a highlight over the whole picture
    spec.shown.light = {0.3, 0.2, 1};
    const auto scene = scene_of(volume, spec);
    const truth::Phong phong(scene, make_view(camera, {.dims = {7, 8, 9}}, width, height));
    const auto pixels = truth::all_pixels(width, height);
    for (const auto& [name, truth] : field_and_sheets) {
      const auto colours = truth(scene, pixels);
      double largest = 0;
      for (std::size_t p = 0; p < pixels.size(); ++p) {
        const glm::dvec3 lit =
            phong.shade(glm::dvec3(1.0), {-3, -2, -1}, -eye_ray(camera, volume.grid, pixels[p]).direction);
        largest = std::max(largest, std::abs(colours[p].x - colours[p].w * lit.x));
      }
      INFO(named(camera) << ": " << name);
      CHECK(largest < 1e-9);
    }
  }
}

TEST_CASE("sheets converge to the field in perspective, too") {
  const Volume volume = sample_field(24, lumps_in_ball);
  for (const Camera& camera : {cameras[0], cameras[4]}) {
    double error[2];
    for (const int slabs : {2, 4}) {
      const auto scene = scene_of(volume, perspective_spec(ramp(0.3, 0.7, 0.4), camera, slabs));
      const auto pixels = truth::all_pixels(width, height);
      const auto sheets = truth::method_truth(scene, pixels), field = truth::field_truth(scene, pixels, 1e-8);
      double sum = 0;
      for (std::size_t p = 0; p < pixels.size(); ++p)
        sum += glm::dot(sheets[p] - field[p], sheets[p] - field[p]);
      error[slabs / 2 - 1] = std::sqrt(sum / double(4 * pixels.size()));
    }
    INFO(fmt::format("{}: {:.3g} {:.3g}", named(camera), error[0], error[1]));
    CHECK(error[0] < 0.002);
    CHECK(error[0] / error[1] > 4);
  }
}

TEST_CASE("a narrow field of view from far away is the orthographic picture") {
  const Volume volume = sample_field(16, lumps_in_ball);
  const Camera far{.azimuth = 31, .elevation = 17, .fov = 0.02}, orthographic{.azimuth = 31, .elevation = 17};
  const auto pixels = truth::all_pixels(width, height);
  for (const auto& [name, truth] : field_and_sheets) {
    const auto a = truth(scene_of(volume, perspective_spec(ramp(0.3, 0.7, 0.4), far)), pixels);
    const auto b = truth(scene_of(volume, perspective_spec(ramp(0.3, 0.7, 0.4), orthographic)), pixels);
    const double largest = largest_difference(a, b);
    INFO(name);
    CHECK(largest > 0);
    CHECK(largest < 1e-3);
  }
}

TEST_CASE("bounds of a perspective view hold all that is visible, and little else") {
  const Volume volume = make_volume({9, 12, 7}, ScalarType::uint8, [](int, int, int) { return 1; });
  for (const Camera& camera : cameras) {
    INFO(named(camera));
    const auto bounds =
        truth::method_bounds(scene_of(volume, perspective_spec(constant_opacity(0.2), camera)));
    std::size_t crossed = 0;
    for (const truth::Pixel pixel : truth::all_pixels(width, height)) {
      if (!(length_in_faces(eye_ray(camera, volume.grid, pixel), volume.grid) > 0)) continue;
      ++crossed;
      REQUIRE(bounds.rows[std::size_t(pixel.y)].contains(pixel.x));
    }
    CHECK(pixels_of(bounds) == crossed);
  }
}

TEST_CASE("the field is seen from inside the volume as well, sheets are not") {
  const Volume volume = make_volume({20, 20, 20}, ScalarType::uint8, [](int, int, int) { return 1; });
  const Camera inside{.azimuth = 20, .elevation = 10, .fov = 60, .distance = 0.2};
  const auto scene = scene_of(volume, perspective_spec(constant_opacity(0.1), inside));
  const auto pixels = truth::all_pixels(width, height);
  const auto field = truth::field_truth(scene, pixels);
  for (std::size_t p = 0; p < pixels.size(); ++p)
    REQUIRE(field[p].w ==
            Approx(1 - std::pow(0.9, length_in_faces(eye_ray(inside, volume.grid, pixels[p]), volume.grid))));
  CHECK_THROWS_AS(truth::method_truth(scene, pixels), InputError);
}

TEST_CASE("splats have no truth in perspective") {
  const Volume volume = make_volume({4, 4, 4}, ScalarType::uint8, [](int, int, int) { return 1; });
  auto scene = scene_of(volume, perspective_spec(constant_opacity(0.1), cameras[0]));
  scene.frame.how = Splats{};
  CHECK_THROWS_AS(truth::method_truth(scene, truth::all_pixels(width, height)), InputError);
}

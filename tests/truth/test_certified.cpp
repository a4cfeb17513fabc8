#include <numbers>

#include "pixel_bounds.hpp"
#include "support/catch.hpp"
#include "truth/certified.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int size = 64;
constexpr double wanted = 0.1 / 255, wanted_lit = 0.5 / 255;

struct Case {
  const char* name;
  Volume volume;
  TransferFunction tf;
  bool nearest = false;
};

TransferFunction with_opacities(std::vector<TransferFunction::OpacityPoint> points) {
  TransferFunction tf = constant_opacity(0);
  tf.colours = {{0, {0.9, 0.2, 0.1}}, {0.5, {0.1, 0.8, 0.3}}, {1, {0.2, 0.3, 1}}};
  tf.opacities = std::move(points);
  return tf;
}

std::vector<Case> hard_cases() {
  const TransferFunction ramp = with_opacities({{0.1, 0}, {1, 0.6}}),
                         jump = with_opacities({{0, 0}, {0.4, 0}, {0.4, 0.5}, {0.7, 0.5}, {0.7, 0.02}}),
                         spikes = with_opacities(
                             {{0.3, 0}, {0.32, 0.7}, {0.34, 0}, {0.6, 0}, {0.61, 0.5}, {0.62, 0}}),
                         opaque = with_opacities({{0.2, 0}, {0.5, 1}});
  const auto labels = [](int x, int y, int z) { return double((x / 3 + y / 4 + z / 5) % 3) / 2; };
  const glm::ivec3 dims(16);
  const auto float32 = ScalarType::float32;
  return {{"lumps, ramp", make_volume(dims, float32, lumps), ramp},
          {"lumps, jumps", make_volume(dims, float32, lumps), jump},
          {"lumps, spikes", make_volume(dims, float32, lumps), spikes},
          {"lumps, opaque", make_volume(dims, float32, lumps), opaque},
          {"noise", make_volume({9, 8, 7}, float32, pattern), ramp},
          {"flat voxels", make_volume({20, 18, 6}, float32, lumps, {1, 1, 4}), spikes},
          {"holes", make_volume(dims, float32, holed), ramp},
          {"infinities", make_volume(dims, float32, endless), ramp},
          {"block", make_volume(dims, float32, block), opaque},
          {"labels", make_volume(dims, float32, labels), ramp, true},
          {"opaque labels", make_volume(dims, float32, labels), opaque, true},
          {"one slice", make_volume({16, 16, 1}, float32, lumps), ramp}};
}

FrameSpec spec_of(const Case& c, const Camera& camera, Shading shading) {
  FrameSpec spec = plain_spec(c.tf, size, camera);
  spec.shown.shading = shading;
  if (c.nearest) spec.shown.interpolation = Interpolation::nearest;
  return spec;
}

}  // namespace

TEST_CASE("the field's integral lies within certified bounds") {
  const auto pixels = random_pixels(size, size, 100, 1);
  for (const Case& c : hard_cases())
    for (const Camera& camera : cameras)
      for (const Shading shading : {Shading::none, Shading::phong}) {
        const double width = shading == Shading::phong ? wanted_lit : wanted;
        const truth::Scene scene = scene_of(c.volume, spec_of(c, camera, shading));
        const auto bounds = truth::certified_bounds(scene, pixels, width);
        CAPTURE(c.name, camera.azimuth, shading);
        CHECK(outside(bounds, truth::field_truth(scene, pixels, 1e-9), 1e-8) == 0);
        CHECK(share_within(bounds, width) >= 0.95);
      }
}

TEST_CASE("the head's certified bounds hold its integral") {
  for (const char* name : {"mr-soft", "mr-surface"})
    for (const Shading shading : {Shading::none, Shading::phong}) {
      FrameSpec spec = plain_spec(head_preset(name), 512, {.azimuth = 20, .elevation = 10});
      spec.shown.shading = shading;
      const truth::Scene scene = scene_of(head(), spec);
      const auto pixels = random_pixels(512, 512, 300, 3);
      const double width = shading == Shading::phong ? wanted_lit : wanted;
      const auto bounds = truth::certified_bounds(scene, pixels, width);
      CAPTURE(name, shading);
      CHECK(outside(bounds, truth::field_truth(scene, pixels, 1e-9), 1e-8) == 0);
      CHECK(share_within(bounds, width) == 1);
    }
}

TEST_CASE("certified bounds hold closed forms") {
  const Volume box =
      make_volume({9, 12, 7}, ScalarType::uint8, [](int, int, int) { return 1; }, {1.0, 0.5, 2.0});
  for (const Camera& camera : cameras) {
    const truth::Scene scene = scene_of(box, plain_spec(constant_opacity(0.2), size, camera));
    const auto pixels = truth::all_pixels(size, size);
    const auto bounds = truth::certified_bounds(scene, pixels, 1e-6);
    std::size_t wrong = 0;
    for (std::size_t p = 0; p < pixels.size(); ++p) {
      const double length =
          truth::length_in_box(truth::cube_ray(scene, pixels[p]), glm::dvec3(0.0), glm::dvec3(1.0));
      const double opacity = -std::expm1(std::log(0.8) * length);
      wrong += !(bounds[p].low.a <= opacity && opacity <= bounds[p].high.a && bounds[p].width() <= 1e-6);
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("certified bounds shrink with the width that is asked for") {
  const auto pixels = random_pixels(size, size, 100, 2);
  const Case smooth = hard_cases().front();
  const truth::Scene scene = scene_of(smooth.volume, spec_of(smooth, cameras[0], Shading::none));
  for (const double width : {1e-3, 1e-5, 1e-6})
    CHECK(share_within(truth::certified_bounds(scene, pixels, width), width) == 1);
  // With little work they are wide, and hold.
  const auto rough = truth::certified_bounds(scene, pixels, 1e-6, 10);
  CHECK(share_within(rough, 1e-3) < 1);
  CHECK(outside(rough, truth::field_truth(scene, pixels, 1e-9), 1e-8) == 0);
}

TEST_CASE("certified bounds tell scenes apart that differ by a millionth") {
  constexpr double millionth = 1e-6;
  const Case c = hard_cases().front();
  const truth::Scene scene = scene_of(c.volume, spec_of(c, cameras[0], Shading::phong));
  const auto pixels = random_pixels(size, size, 80, 5);
  const auto bounds = truth::certified_bounds(scene, pixels, 5e-9);
  const auto changed = [&](const char* what, const std::function<void(truth::Scene&)>& change) {
    truth::Scene other = scene;
    change(other);
    INFO(what);
    CHECK(outside(bounds, truth::field_truth(other, pixels, 1e-10), 0) > 0);
  };
  changed("azimuth", [](auto& s) { s.frame.shown.camera.azimuth += 57 * millionth; });
  changed("elevation", [](auto& s) { s.frame.shown.camera.elevation += 57 * millionth; });
  changed("roll", [](auto& s) { s.frame.shown.camera.roll += 57 * millionth; });
  changed("zoom", [](auto& s) { s.frame.shown.camera.zoom *= 1 + millionth; });
  changed("pan", [](auto& s) { s.frame.shown.camera.pan[0] += millionth; });
  changed("spacing", [](auto& s) { s.grid.spacing.x *= 1 + millionth; });
  changed("opacity", [](auto& s) { s.frame.shown.transfer_function.opacities.back().opacity += millionth; });
  changed("opacity's value",
          [](auto& s) { s.frame.shown.transfer_function.opacities[0].value += millionth; });
  changed("colour", [](auto& s) { s.frame.shown.transfer_function.colours[1].srgb.g += millionth; });
  changed("voxels", [](auto& s) {
    for (double& v : s.values) v *= 1 + millionth;
  });
  changed("ambient light", [](auto& s) { s.frame.shown.material.ambient += millionth; });
  changed("diffuse light", [](auto& s) { s.frame.shown.material.diffuse += millionth; });
  changed("specular light", [](auto& s) { s.frame.shown.material.specular += 3 * millionth; });
  changed("exponent", [](auto& s) { s.frame.shown.material.exponent += 240 * millionth; });
  changed("direction of light", [](auto& s) { s.frame.shown.light.x += millionth; });
}

TEST_CASE("rays in doubles lie within a ten-thousandth of a millionth of a voxel") {
  // In 80 bits: the camera's axes, and a pixel's ray through the box's middle plane (docs/certified.md, 1).
  using Real = long double;
  const glm::ivec3 dims(500, 400, 300);
  const Volume volume{make_grid(dims, ScalarType::uint8, {1.0, 1.5, 0.75}), {}};
  truth::Scene scene{volume.grid, {}, plain_spec(constant_opacity(0.5), 512)};
  const Real degree = std::numbers::pi_v<Real> / 180;
  for (const Camera& camera :
       {cameras[0], cameras[2], cameras[3], Camera{.azimuth = 123.4, .elevation = -71}}) {
    scene.frame.shown.camera = camera;
    const Real sa = std::sin(camera.azimuth * degree), ca = std::cos(camera.azimuth * degree),
               se = std::sin(camera.elevation * degree), ce = std::cos(camera.elevation * degree),
               sr = std::sin(camera.roll * degree), cr = std::cos(camera.roll * degree);
    const std::array<Real, 3> right0{ca, sa, 0}, up0{-se * sa, se * ca, ce};
    Real radius = 0;
    for (int k = 0; k < 3; ++k) radius += std::pow(Real(0.5) * dims[k] * Real(volume.grid.spacing[k]), 2);
    radius = std::sqrt(radius);
    const Real unit = 2 * radius / (512 * Real(camera.zoom));  // world lengths a pixel
    for (const truth::Pixel pixel : {truth::Pixel{0, 0}, {511, 3}, {256, 256}, {100, 400}}) {
      const truth::LatticeRay ray = truth::Rays(scene).through(pixel);
      const Real x = (pixel.x + Real(0.5) - 256 - Real(camera.pan[0]) * 512) * unit,
                 y = -(pixel.y + Real(0.5) - 256 - Real(camera.pan[1]) * 512) * unit;
      std::array<Real, 3> apart{}, along{ce * sa, -ce * ca, se};
      Real dot = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Real right = cr * right0[k] + sr * up0[k], up = cr * up0[k] - sr * right0[k];
        const Real world =
            (Real(ray.origin[int(k)]) - Real(dims[int(k)] - 1) / 2) * Real(volume.grid.spacing[int(k)]);
        apart[k] = world - (x * right + y * up);
        dot += apart[k] * along[k];
      }
      Real square = 0;
      for (std::size_t k = 0; k < 3; ++k) square += std::pow((apart[k] - dot * along[k]) / Real(0.75), 2);
      CHECK(double(std::sqrt(square)) < 1e-11);
      for (std::size_t k = 0; k < 3; ++k) {
        const Real step = Real(ray.step[int(k)]) * Real(volume.grid.spacing[int(k)]) / Real(0.75);
        CHECK(double(std::abs(step + along[k])) < 1e-13);
      }
    }
  }
}

#include <numbers>

#include "pixel_bounds.hpp"
#include "support/catch.hpp"
#include "truth/certified.hpp"
#include "truth/passage.hpp"
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

const std::vector<std::vector<ClipPlane>> cuts{{{{0.4, 1, -0.3}, -1.3}},
                                               {{{-1, 0.2, 0.5}, -2}, {{0.3, -0.7, 0.9}, -0.5}},
                                               {{{0, 1, 0}, -2.5}, {{-0.01, -1, 0}, -4}}};

FrameSpec spec_of(const Case& c, const Camera& camera, Shading shading) {
  FrameSpec spec = plain_spec(c.tf, size, camera);
  spec.shown.shading = shading;
  if (c.nearest) spec.shown.interpolation = Interpolation::nearest;
  return spec;
}

/// A pixel's ray and places on it, in 80 bits, in world lengths from the volume's middle.
using Real = long double;
struct ExactRay {
  std::array<Real, 3> from{}, along{};
  Real unit = 0;  ///< world lengths a pixel
  const Grid& grid;

  ExactRay(const Grid& of, const Camera& camera, truth::Pixel pixel, int pixels) : grid(of) {
    const Real degree = std::numbers::pi_v<Real> / 180;
    const Real sa = std::sin(camera.azimuth * degree), ca = std::cos(camera.azimuth * degree),
               se = std::sin(camera.elevation * degree), ce = std::cos(camera.elevation * degree),
               sr = std::sin(camera.roll * degree), cr = std::cos(camera.roll * degree);
    const std::array<Real, 3> right0{ca, sa, 0}, up0{-se * sa, se * ca, ce};
    along = {-ce * sa, ce * ca, -se};
    Real radius = 0;
    for (int k = 0; k < 3; ++k) radius += std::pow(Real(0.5) * grid.dims[k] * Real(grid.spacing[k]), 2);
    unit = 2 * std::sqrt(radius) / (pixels * Real(camera.zoom));
    const Real half = Real(pixels) / 2,
               x = (pixel.x + Real(0.5) - half - Real(camera.pan[0]) * pixels) * unit,
               y = -(pixel.y + Real(0.5) - half - Real(camera.pan[1]) * pixels) * unit;
    for (std::size_t k = 0; k < 3; ++k)
      from[k] = x * (cr * right0[k] + sr * up0[k]) + y * (cr * up0[k] - sr * right0[k]);
  }
  std::array<Real, 3> world(const glm::dvec3& place) const {
    std::array<Real, 3> at{};
    for (std::size_t k = 0; k < 3; ++k)
      at[k] = (Real(place[int(k)]) - Real(grid.dims[int(k)] - 1) / 2) * Real(grid.spacing[int(k)]);
    return at;
  }
  static Real dot(const std::array<Real, 3>& a, const std::array<Real, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
};

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
  truth::Scene scene = scene_of(c.volume, spec_of(c, cameras[0], Shading::phong));
  scene.frame.shown.clip_planes = {{{0.4, -1, -0.3}, -2}};
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
  changed("clip plane's distance", [](auto& s) { s.frame.shown.clip_planes[0].distance += millionth; });
  changed("clip plane's direction", [](auto& s) { s.frame.shown.clip_planes[0].normal.x += millionth; });
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
  const Volume volume{make_grid({500, 400, 300}, ScalarType::uint8, {1.0, 1.5, 0.75}), {}};
  truth::Scene scene{volume.grid, {}, plain_spec(constant_opacity(0.5), 512)};
  for (const Camera& camera :
       {cameras[0], cameras[2], cameras[3], Camera{.azimuth = 123.4, .elevation = -71}}) {
    scene.frame.shown.camera = camera;
    for (const truth::Pixel pixel : {truth::Pixel{0, 0}, {511, 3}, {256, 256}, {100, 400}}) {
      const truth::LatticeRay ray = truth::Rays(scene).through(pixel);
      const ExactRay exact(volume.grid, camera, pixel, 512);
      std::array<Real, 3> apart = exact.world(ray.origin);
      for (std::size_t k = 0; k < 3; ++k) apart[k] -= exact.from[k];
      const Real dot = ExactRay::dot(apart, exact.along);
      Real square = 0;
      for (std::size_t k = 0; k < 3; ++k)
        square += std::pow((apart[k] - dot * exact.along[k]) / Real(0.75), 2);
      CHECK(double(std::sqrt(square)) < 1e-11);
      for (std::size_t k = 0; k < 3; ++k) {
        const Real step = Real(ray.step[int(k)]) * Real(volume.grid.spacing[int(k)]) / Real(0.75);
        CHECK(double(std::abs(step - exact.along[k])) < 1e-13);
      }
    }
  }
}

TEST_CASE("certified bounds hold what clip planes and a clip box leave") {
  const auto pixels = random_pixels(size, size, 60, 4);
  for (const Case& c : hard_cases())
    for (const Camera& camera : cameras)
      for (const auto& planes : cuts) {
        const Shading shading = planes.size() == 1 ? Shading::phong : Shading::none;
        FrameSpec spec = spec_of(c, camera, shading);
        spec.shown.clip_planes = planes;
        if (planes.size() == 1 && c.volume.grid.dims.z > 6) spec.shown.clip = VoxelBox{{1, 2, 1}, {8, 7, 6}};
        const double width = shading == Shading::phong ? wanted_lit : wanted;
        const truth::Scene scene = scene_of(c.volume, spec);
        const auto bounds = truth::certified_bounds(scene, pixels, width);
        CAPTURE(c.name, camera.azimuth, planes[0].distance);
        CHECK(outside(bounds, truth::field_truth(scene, pixels, 1e-9), 1e-8) == 0);
        // On either side of a plane between voxels they may be opaque or not.
        if (planes[0].normal.x != 0 || !c.nearest) CHECK(share_within(bounds, width) >= 0.9);
      }
}

TEST_CASE("certified bounds hold the closed form of what planes leave, and nothing beside a millionth") {
  // From the front rays go along y: 12 voxels of it are 15 long.
  const Volume even =
      make_volume({10, 12, 10}, ScalarType::float32, [](int, int, int) { return 1; }, {1, 1.25, 1});
  FrameSpec spec = plain_spec(constant_opacity(0.3), 32);
  const auto check_length = [&](const std::vector<ClipPlane>& planes, double length) {
    spec.shown.clip_planes = planes;
    const auto bounds =
        truth::certified_bounds(scene_of(even, spec), std::vector{truth::Pixel{16, 16}}, 1e-8);
    INFO("length " << length);
    CHECK(bounds[0].width() < 1e-8);
    const auto opacity = [&](double of) { return 1 - std::pow(0.7, of); };
    CHECK(bounds[0].low.a <= opacity(length));
    CHECK(opacity(length) <= bounds[0].high.a);
    for (const double apart : {-1e-6, 1e-6})
      if (length > 0)
        CHECK((bounds[0].low.a > opacity(length + apart) || opacity(length + apart) > bounds[0].high.a));
  };
  check_length({{{0, 1, 0}, 3.2}}, 7.5 - 3.2);
  check_length({{{0, -5, 0}, 3.2}}, 7.5 - 3.2);
  check_length({{{0, 1, 0}, -1}, {{0, -1, 0}, -1.5}}, 2.5);
  check_length({{{0, 1, 0}, 1}, {{0, -1, 0}, 1}}, 0);
  check_length({{{1, 0, 0}, 2}}, 0);
  check_length({{{1, 0, 0}, -2}}, 15);
  check_length({{{0, 1, 0}, -7.5}}, 15);  // in the volume's face
  // A ray in a plane may be on either side.
  spec.shown.clip_planes = {{{1, 0, 0}, truth::Rays(scene_of(even, spec)).through({16, 16}).origin.x - 4.5}};
  const auto beside = truth::certified_bounds(scene_of(even, spec),
                                              std::vector{truth::Pixel{15, 16}, {16, 16}, {17, 16}}, 1e-6);
  CHECK(beside[0].high.a == 0);
  CHECK(beside[1].width() == 1);
  CHECK(beside[2].width() < 1e-6);
}

TEST_CASE("a clip plane's crossing in 80 bits is as near as it is said to be") {
  const Volume volume{make_grid({500, 400, 300}, ScalarType::uint8, {1.0, 1.5, 0.75}), {}};
  truth::Scene scene{volume.grid, {}, plain_spec(constant_opacity(0.5), 512)};
  int beside = 0;
  for (const Camera& camera :
       {cameras[0], cameras[3], Camera{.azimuth = 123.4, .elevation = -71}, Camera{.azimuth = 1e-4}})
    for (const ClipPlane& plane :
         {ClipPlane{{0.4, 1, -0.3}, -31.3}, {{1, 1e-3, 0}, 20.7}, {{-7, 2, 90}, 0.1}}) {
      scene.frame.shown.camera = camera;
      scene.frame.shown.clip_planes = {plane};
      const truth::Rays rays(scene);
      for (const truth::Pixel pixel : {truth::Pixel{9, 0}, {511, 3}, {256, 256}, {100, 400}}) {
        const truth::LatticeRay ray = rays.uncut().through(pixel);
        const auto cut = truth::plane_crossing(ray, rays.planes()[0]);
        REQUIRE(cut.has_value());
        const ExactRay exact(volume.grid, camera, pixel, 512);
        const std::array<Real, 3> normal{plane.normal.x, plane.normal.y, plane.normal.z};
        // Along the exact ray from the computed one's start, in unit lengths of 0.75.
        const auto crossed_at = [&](Real distance) {
          std::array<Real, 3> apart = exact.world(ray.origin);
          for (std::size_t k = 0; k < 3; ++k) apart[k] -= exact.from[k];
          const Real along =
              (distance * std::sqrt(ExactRay::dot(normal, normal)) - ExactRay::dot(normal, exact.from)) /
              ExactRay::dot(normal, exact.along);
          return double((along - ExactRay::dot(apart, exact.along)) / Real(0.75) - cut->at);
        };
        CHECK(std::abs(crossed_at(plane.distance)) <= cut->by);
        // What rounding in this function alone allows would not do.
        beside += std::abs(crossed_at(plane.distance)) > 1e-15 * std::abs(cut->at);
        CHECK(std::abs(crossed_at(plane.distance + Real(1e-6))) > cut->by);
      }
    }
  CHECK(beside > 0);
}

TEST_CASE("bounds hold whichever of two faces a ray through an edge crosses first") {
  // A ray along the diagonal goes through edges of clear voxels, beside which all are dense.
  const Case board{
      "board",
      make_volume(glm::ivec3(8), ScalarType::float32, [](int x, int y, int) { return double((x + y) % 2); }),
      with_opacities({{0, 0}, {1, 1}}), true};
  FrameSpec spec = spec_of(board, {.azimuth = -45}, Shading::none);
  spec.shown.width = spec.shown.height = 9;
  const std::vector<truth::Pixel> middle{{4, 4}};
  const auto bounds = truth::certified_bounds(scene_of(board.volume, spec), middle, wanted);
  CHECK(bounds.front().high.a > 0.9);
  for (const double beside : {-1e-11, 0.0, 1e-11}) {
    spec.shown.camera.azimuth = -45 + beside;
    CHECK(outside(bounds, truth::field_truth(scene_of(board.volume, spec), middle, 1e-9), 1e-8) == 0);
  }
}

TEST_CASE("bounds hold what is on either side of a face that a clip plane lies in") {
  // From straight before: opaque voxels, behind whose last face the plane cuts.
  const Case halves{
      "halves",
      make_volume(glm::ivec3(16), ScalarType::float32, [](int, int y, int) { return y < 6 ? 1 : 0.5; }),
      with_opacities({{0, 0}, {0.5, 0.2}, {0.9, 1}}), true};
  FrameSpec spec = spec_of(halves, {.zoom = 1.1}, Shading::none);
  const std::vector<truth::Pixel> pixels{{20, 31}, {40, 33}};
  const auto bounds_at = [&](double distance) {
    spec.shown.clip_planes = {{{0, 1, 0}, distance}};
    return truth::certified_bounds(scene_of(halves.volume, spec), pixels, wanted);
  };
  const auto in_face = bounds_at(-2);
  CHECK(share_within(in_face, 0.1) == 0);
  CHECK(share_within(bounds_at(-1.9), wanted) == 1);
  for (const double beside : {-1e-11, 0.0, 1e-11}) {
    spec.shown.clip_planes[0].distance = -2 + beside;
    CHECK(outside(in_face, truth::field_truth(scene_of(halves.volume, spec), pixels, 1e-9), 1e-8) == 0);
  }
}

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <random>

#include "ringsplat/base/error.hpp"
#include "ringsplat/view/view.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

namespace {

/// A lattice that is anisotropic, oblique and far from the origin.
LatticeFrame tilted() {
  LatticeFrame lattice{.dims = {40, 24, 9}, .spacing = {0.5, 0.8, 3}, .origin = {100, -200, 50}};
  lattice.direction[2] = glm::normalize(glm::dvec3(0.3, -0.4, 1.0));
  return lattice;
}

glm::dvec3 world(const LatticeFrame& lattice, const glm::dvec3& p) {
  return lattice.origin + lattice.direction * (lattice.spacing * p);
}

double bounding_radius(const LatticeFrame& lattice) {
  double radius = 0;
  for (int c = 0; c < 8; ++c)
    radius = std::max(
        radius,
        glm::length(lattice.direction * (lattice.spacing * 0.5 * glm::dvec3(lattice.dims) *
                                         glm::dvec3((c & 1) ? 1 : -1, (c & 2) ? 1 : -1, (c & 4) ? 1 : -1))));
  return radius;
}

Traversal traversal_of(const Camera& camera, const LatticeFrame& lattice) {
  return choose_traversal(make_view(camera, lattice, 256, 192), lattice);
}

}  // namespace

TEST_CASE("the eye stands before the box's centre, so far that the fields of view agree") {
  const LatticeFrame lattice = tilted();
  const glm::dvec3 centre = world(lattice, 0.5 * glm::dvec3(lattice.dims - 1));
  for (const double zoom : {0.5, 1.0, 3.0}) {
    const Camera camera{.azimuth = 31, .elevation = 17, .roll = 9, .zoom = zoom, .fov = 40};
    const auto view = make_view(camera, lattice, 256, 192);
    REQUIRE(view.eye);
    const glm::dvec3 away = world(lattice, *view.eye) - centre;
    CHECK(glm::length(away - glm::length(away) * view.to_viewer) < 1e-9 * glm::length(away));
    CHECK(glm::length(away) == Approx(bounding_radius(lattice) / std::tan(M_PI / 9)));
    Camera orthographic = camera;
    orthographic.fov = 0;
    CHECK(make_view(orthographic, lattice, 256, 192).linear == view.linear);
  }
}

TEST_CASE("a target moves the eye of a fitted view aside only, unless it lies before the box") {
  const LatticeFrame lattice{.dims = {40, 24, 10}};
  const auto distance = [&](std::optional<double> before_centre) {
    // Seen from above: the box reaches half of ten voxels towards the viewer.
    Camera camera{.elevation = 90, .fov = 40, .fit = Fit::box};
    if (before_centre) camera.target = glm::dvec3(25, 8, 4.5 + *before_centre);
    return make_view(camera, lattice, 256, 192).eye->z - 4.5;
  };
  const double usual = distance(std::nullopt);
  for (const double inside : {-20.0, -3.0, 0.0, 4.9}) CHECK(distance(inside) == Approx(usual));
  for (const double outside : {0.5, 7.0}) CHECK(distance(5 + outside) == Approx(usual + outside));
}

TEST_CASE("a given distance decides how large the volume appears") {
  const LatticeFrame lattice = tilted();
  const double radius = bounding_radius(lattice);
  for (const double distance : {1.5, 4.0, 1e4}) {
    const Camera camera{.azimuth = 31, .elevation = 17, .fov = 40, .distance = distance};
    const auto view = make_view(camera, lattice, 256, 192);
    const glm::dvec3 centre = world(lattice, 0.5 * glm::dvec3(lattice.dims - 1));
    CHECK(glm::length(world(lattice, *view.eye) - centre) == Approx(distance * radius));
    CHECK(view.pixels_per_unit * distance * radius * std::tan(M_PI / 9) == Approx(96));
  }
}

TEST_CASE("a point is seen where the ray from the eye through it meets the plane of depth 0") {
  const LatticeFrame lattice = tilted();
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> number(-0.5, 0.5);
  for (const Camera& camera :
       {Camera{.azimuth = 31, .elevation = 17, .roll = 20, .fov = 40},
        Camera{.azimuth = 200, .elevation = -50, .zoom = 2, .fov = 80, .distance = 1.1}}) {
    const auto view = make_view(camera, lattice, 256, 192);
    for (int trial = 0; trial < 100; ++trial) {
      const glm::dvec3 p =
          (glm::dvec3(number(random), number(random), number(random)) + 0.5) * glm::dvec3(lattice.dims) - 0.5;
      const glm::dvec2 pixel = view.seen_at(p);
      const glm::dvec3 on_plane = glm::inverse(view.linear) * (glm::dvec3(pixel, 0) - view.offset);
      const glm::dvec3 a = glm::normalize(world(lattice, on_plane) - world(lattice, *view.eye)),
                       b = glm::normalize(world(lattice, p) - world(lattice, *view.eye));
      REQUIRE(glm::length(a - b) < 1e-9);
    }
    CHECK(view.magnification(*view.eye) == std::numeric_limits<double>::infinity());
    CHECK(view.magnification(0.5 * glm::dvec3(lattice.dims - 1)) == Approx(1));
  }
}

TEST_CASE("an orthographic view has no eye and magnifies nothing") {
  const auto view = make_view({.azimuth = 10}, tilted(), 64, 64);
  CHECK_FALSE(view.eye);
  CHECK(view.magnification({1, 2, 3}) == 1);
  CHECK(view.seen_at({1, 2, 3}) == glm::dvec2(view.project({1, 2, 3})));
}

TEST_CASE("a pan moves the whole picture, in perspective as well") {
  for (const double fov : {0.0, 40.0}) {
    Camera camera{.azimuth = 31, .elevation = 17, .zoom = 1.5, .fov = fov};
    const LatticeFrame lattice{.dims = {20, 30, 25}};
    const ViewTransform view = make_view(camera, lattice, 200, 100);
    camera.pan = {0.25, -0.5};
    const ViewTransform panned = make_view(camera, lattice, 200, 100);
    for (const glm::dvec3& p : {glm::dvec3(0), glm::dvec3(19, 3, 24), glm::dvec3(10, 29, 2)}) {
      const glm::dvec2 moved = panned.seen_at(p) - view.seen_at(p);
      CHECK(moved.x == Approx(25).margin(1e-9));
      CHECK(moved.y == Approx(-50).margin(1e-9));
    }
  }
}

TEST_CASE("an eye that looks at a target sees it in the middle, with up upwards") {
  const LatticeFrame lattice = tilted();
  const glm::dvec3 eye{130, -260, 90}, target{108, -190, 60};
  for (const double fov : {0.0, 40.0}) {
    const ViewTransform view =
        make_view({.fov = fov, .eye = eye, .target = target, .up = {0, 1, 2}}, lattice, 200, 100);
    const auto seen = [&](const glm::dvec3& place) {
      return view.seen_at(glm::inverse(lattice.direction) * (place - lattice.origin) / lattice.spacing);
    };
    CHECK(glm::length(seen(target) - glm::dvec2(100, 50)) < 1e-9);
    const glm::dvec2 above = seen(target + glm::dvec3(0, 1, 2));
    CHECK(above.x == Approx(100).margin(1e-9));
    CHECK(above.y < 50);
    CHECK(glm::length(view.to_viewer - glm::normalize(eye - target)) < 1e-12);
    CHECK(glm::dot(glm::cross(view.right, view.up), view.to_viewer) == Approx(1));
    if (fov == 0) continue;
    CHECK(glm::length(world(lattice, *view.eye) - eye) < 1e-9);
    // At the target's depth the shorter side is as wide as the field of view says.
    const double half = glm::length(eye - target) * std::tan(fov * M_PI / 360);
    CHECK(seen(target + half * view.up).y == Approx(0).margin(1e-6));
  }
}

TEST_CASE("angles turn about the target") {
  const LatticeFrame lattice = tilted();
  const glm::dvec3 corner = world(lattice, {39, 0, 8});
  for (const double azimuth : {0.0, 70.0, 200.0}) {
    const ViewTransform view =
        make_view({.azimuth = azimuth, .elevation = 20, .target = corner}, lattice, 200, 100);
    CHECK(glm::length(view.seen_at({39, 0, 8}) - glm::dvec2(100, 50)) < 1e-9);
  }
}

TEST_CASE("perspective cameras that cannot be are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double fov : {-40.0, 0.001, 180.0, 400.0, nan})
    CHECK_THROWS_AS(make_view({.fov = fov}, {.dims = glm::ivec3(8)}, 64, 64), InputError);
  for (const double distance : {-2.0, 1e6, nan})
    CHECK_THROWS_AS(make_view({.fov = 40, .distance = distance}, {.dims = glm::ivec3(8)}, 64, 64),
                    InputError);
  CHECK_THROWS_AS(make_view({.distance = 3}, {.dims = glm::ivec3(8)}, 64, 64), InputError);
  const Camera matrix{.matrix = std::array<double, 12>{2, 0, 0, 50, 0, 0, -2, 50, 0, 2, 0, 0}, .fov = 40};
  CHECK(message_of([&] { make_view(matrix, {.dims = glm::ivec3(8)}, 64, 64); }).find("matrix") !=
        std::string::npos);
}

TEST_CASE("seen from far enough the axis, order and distance are those of the orthographic view") {
  const LatticeFrame lattice = tilted();
  for (const double azimuth : {0.0, 70.0, 190.0, 280.0})
    for (const double elevation : {-70.0, -10.0, 20.0, 85.0}) {
      Camera camera{.azimuth = azimuth, .elevation = elevation};
      const auto expected = traversal_of(camera, lattice);
      camera.fov = 20;
      const auto t = traversal_of(camera, lattice);
      INFO(azimuth << ' ' << elevation);
      CHECK(t.axis == expected.axis);
      CHECK(t.ascending == expected.ascending);
      CHECK(t.slice_distance == Approx(expected.slice_distance));
    }
}

TEST_CASE("all rays of a perspective view meet the slices in the chosen order") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> angle(-180, 180), size(1, 60), radii(0.1, 2);
  int inside = 0, other_axis = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const LatticeFrame lattice{.dims = {int(size(random)), int(size(random)), int(size(random))}};
    Camera camera{
        .azimuth = angle(random), .elevation = angle(random) / 2, .fov = 60, .distance = radii(random)};
    const auto view = make_view(camera, lattice, 64, 64);
    const glm::dvec3 low(-0.5), high = glm::dvec3(lattice.dims) - 0.5;
    if (glm::clamp(*view.eye, low, high) == *view.eye) {
      ++inside;
      REQUIRE_THROWS_AS(choose_traversal(view, lattice), InputError);
      continue;
    }
    const auto t = choose_traversal(view, lattice);
    const int k = int(t.axis);
    for (const double end : {low[k], high[k]}) REQUIRE((end > (*view.eye)[k]) == t.ascending);
    auto parallel = view;
    parallel.eye.reset();
    other_axis += choose_traversal(parallel, lattice).axis != t.axis;
  }
  CHECK(inside > 100);
  CHECK(other_axis > 20);
}

TEST_CASE("an eye beside a long box takes the slices it is outside of") {
  const LatticeFrame rod{.dims = {100, 4, 4}};
  // Mostly along x, but the eye stands above the rod.
  const auto t = traversal_of({.azimuth = 90, .elevation = 10, .fov = 60, .distance = 0.5}, rod);
  CHECK(t.axis == Axis::z);
  CHECK_FALSE(t.ascending);
}

TEST_CASE("an eye inside the box is refused with what to do about it") {
  const LatticeFrame lattice{.dims = glm::ivec3(16)};
  const std::string message =
      message_of([&] { traversal_of({.azimuth = 10, .fov = 60, .distance = 0.3}, lattice); });
  CHECK(message.find("inside") != std::string::npos);
  CHECK(message.find("--distance") != std::string::npos);
}

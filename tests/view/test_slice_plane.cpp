#include <cmath>
#include <random>

#include "support/catch.hpp"
#include "view/slice_plane.hpp"

using namespace ringsplat;

namespace {

constexpr int width = 200, height = 160;
constexpr double radius = 1.6;

LatticeFrame lattice_of(glm::ivec3 dims, glm::dvec3 spacing = glm::dvec3(1.0)) {
  LatticeFrame lattice;
  lattice.dims = dims;
  lattice.spacing = spacing;
  return lattice;
}

struct Planned {
  ViewTransform screen;
  Axis axis;
  SlicePlane plane;

  glm::dvec2 pixels_a_voxel() const {
    const auto [u, v] = in_plane(axis);
    return {plane.view.linear[u].x, plane.view.linear[v].y};
  }
};

Planned plan(const Camera& camera, const LatticeFrame& lattice, int samples = 1) {
  const ViewTransform screen = make_view(camera, lattice, width, height);
  const Axis axis = choose_traversal(screen, lattice).axis;
  return {screen, axis, make_slice_plane(screen, axis, lattice.dims, samples, radius, width, height)};
}

Camera random_camera(std::mt19937& random, double zoom) {
  std::uniform_real_distribution<double> degrees(-180, 180);
  return {
      .azimuth = degrees(random), .elevation = degrees(random) / 2, .roll = degrees(random), .zoom = zoom};
}

}  // namespace

TEST_CASE("a voxel's place in the slices' plane is the one its place on the screen is warped to") {
  std::mt19937 random(1);
  for (int k = 0; k < 200; ++k) {
    const auto lattice = lattice_of({40, 33, 27}, {1.0, 0.7, 1.9});
    const auto [screen, axis, plane] = plan(random_camera(random, 3), lattice);
    for (const glm::dvec3 voxel : {glm::dvec3(0), glm::dvec3(39, 32, 26), glm::dvec3(11, 29, 3)}) {
      const glm::dvec2 place(plane.view.project(voxel)),
          warped = plane.warp.from_screen(glm::dvec2(screen.project(voxel)));
      CHECK(std::abs(place.x - warped.x) < 1e-6);
      CHECK(std::abs(place.y - warped.y) < 1e-6);
      CHECK(plane.view.project(voxel).z == screen.project(voxel).z);
    }
  }
}

TEST_CASE("all voxels of a slice have the very same place among the pixels") {
  std::mt19937 random(2);
  for (int k = 0; k < 200; ++k) {
    const auto lattice = lattice_of({1000, 800, 900});
    const int samples = 1 << (k % 3);
    const Planned planned = plan(random_camera(random, 60), lattice, samples);
    const auto& [screen, axis, plane] = planned;
    REQUIRE(planned.pixels_a_voxel() == glm::dvec2(samples));
    const auto [u, v] = in_plane(axis);
    glm::dvec3 first(0.0), last(0.0);
    first[int(axis)] = last[int(axis)] = 777;
    last[u] = 799;
    last[v] = 751;
    const glm::dvec3 from = plane.view.project(first), to = plane.view.project(last);
    CHECK(to.x - from.x == 799.0 * samples);
    CHECK(to.y - from.y == 751.0 * samples);
  }
}

TEST_CASE("the slices' plane holds what the screen shows, and not much more") {
  std::mt19937 random(3);
  for (int k = 0; k < 300; ++k) {
    const double zoom = std::exp2(k % 7 - 2);
    const Planned planned = plan(random_camera(random, zoom), lattice_of({30, 30, 30}), 1 + k % 2);
    const auto& [screen, axis, plane] = planned;
    const glm::dvec2 reach = glm::max(radius * planned.pixels_a_voxel(), glm::dvec2(1.0));
    glm::dvec2 low(1e300), high(-1e300);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec2 place(
          plane.view.project(glm::dvec3(corner & 1 ? 29 : 0, corner & 2 ? 29 : 0, corner & 4 ? 29 : 0)));
      low = glm::min(low, place - reach);
      high = glm::max(high, place + reach);
    }
    // For every screen pixel: either nothing reaches its place, or its sixteen neighbours are in the plane.
    for (const double x : {0.5, 77.5, width - 0.5}) {
      for (const double y : {0.5, 91.5, height - 0.5}) {
        const glm::dvec2 place = plane.warp.from_screen({x, y});
        if (glm::any(glm::lessThan(place, low - 2.0)) || glm::any(glm::greaterThan(place, high + 2.0)))
          continue;
        CHECK((place.x >= 1.5 && place.x < plane.width - 1.5 && place.y >= 1.5 &&
               place.y < plane.height - 1.5));
      }
    }
    CHECK(plane.width <= high.x - low.x + 10);
    CHECK(plane.height <= high.y - low.y + 10);
  }
}

TEST_CASE("the slices' plane is never finer than the screen") {
  const Planned planned = plan({.azimuth = 20, .elevation = 10}, lattice_of({2000, 1500, 1000}), 2);
  const auto& [screen, axis, plane] = planned;
  const auto [u, v] = in_plane(axis);
  CHECK(planned.pixels_a_voxel().x == Approx(glm::length(glm::dvec2(screen.linear[u]))).epsilon(2e-3));
  CHECK(planned.pixels_a_voxel().y == Approx(glm::length(glm::dvec2(screen.linear[v]))).epsilon(2e-3));
  CHECK(plane.width <= 1.5 * width);
}

TEST_CASE("a view that shows a corner has a plane for the corner") {
  const auto lattice = lattice_of({100, 100, 100});
  const auto whole = plan({.azimuth = 10, .elevation = 5, .roll = 0, .zoom = 1}, lattice).plane;
  const auto part = plan({.azimuth = 10, .elevation = 5, .roll = 0, .zoom = 8}, lattice).plane;
  CHECK(part.width * part.height < 0.1 * whole.width * whole.height);
}

TEST_CASE("a view beside the volume has a plane of some pixels, and one too large is refused") {
  const LatticeFrame lattice = lattice_of({20, 20, 20});
  const std::array<double, 12> beside{1, 0, 0, 5000, 0, 0, -1, 5000, 0, 1, 0, 0};
  const auto [screen, axis, plane] =
      plan({.azimuth = 0, .elevation = 0, .roll = 0, .zoom = 1, .matrix = beside}, lattice);
  CHECK(plane.width >= 1);
  CHECK(plane.height >= 1);
  CHECK(plane.width * plane.height < 5000);
  // Rows and columns nearly parallel on the screen, of a slice millions of voxels wide.
  ViewTransform oblique;
  oblique.linear = glm::dmat3(1, 0, 0, 1, 1e-6, 0, 0, 0, 1);
  CHECK_THROWS_WITH(make_slice_plane(oblique, Axis::z, {3000000, 3000000, 1}, 1, radius, width, height),
                    Catch::Matchers::Contains("image-plane"));
}

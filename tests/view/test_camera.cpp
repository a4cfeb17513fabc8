#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <random>

#include "ringsplat/base/error.hpp"
#include "ringsplat/view/view.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "view/matrices.hpp"

using namespace ringsplat;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

/// Eleven voxels a side, so that the centre is lattice point (5, 5, 5).
const LatticeFrame cube{.dims = glm::ivec3(11)};

Camera looking(double azimuth, double elevation, double roll = 0) {
  return {.azimuth = azimuth, .elevation = elevation, .roll = roll};
}

/// Where one step along world axis `axis` goes in the picture, in steps: (right, down, away).
glm::dvec3 on_screen(const Camera& camera, int axis) {
  const auto view = make_view(camera, cube, 200, 200);
  return view.linear[axis] / view.pixels_per_unit;
}

void require_close(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  INFO(a.x << ' ' << a.y << ' ' << a.z << "  expected  " << b.x << ' ' << b.y << ' ' << b.z);
  REQUIRE(std::abs(a.x - b.x) <= tolerance);
  REQUIRE(std::abs(a.y - b.y) <= tolerance);
  REQUIRE(std::abs(a.z - b.z) <= tolerance);
}

}  // namespace

TEST_CASE("sine and cosine are exact at multiples of 90 degrees and right elsewhere") {
  const double expected[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
  for (int turn = -9; turn <= 9; ++turn) {
    const auto [s, c] = sin_cos_degrees(90.0 * turn);
    REQUIRE(s == expected[turn & 3][0]);
    REQUIRE(c == expected[turn & 3][1]);
  }
  for (double degrees = -720; degrees <= 720; degrees += 0.37) {
    const auto [s, c] = sin_cos_degrees(degrees);
    const long double radians =
        static_cast<long double>(degrees) * 3.14159265358979323846264338327950288L / 180;
    REQUIRE(std::abs(double(s - std::sin(radians))) < 4e-16);
    REQUIRE(std::abs(double(c - std::cos(radians))) < 4e-16);
  }
}

TEST_CASE("the camera at rest looks along +y with +x at the right and +z up") {
  REQUIRE(on_screen({}, 0) == glm::dvec3(1, 0, 0));
  REQUIRE(on_screen({}, 1) == glm::dvec3(0, 0, 1));
  REQUIRE(on_screen({}, 2) == glm::dvec3(0, -1, 0));
}

TEST_CASE("azimuth 90 stands at +x, elevation 90 looks down, roll 90 turns the picture clockwise") {
  REQUIRE(on_screen(looking(90, 0), 0) == glm::dvec3(0, 0, -1));  // +x is nearest
  REQUIRE(on_screen(looking(90, 0), 1) == glm::dvec3(1, 0, 0));
  REQUIRE(on_screen(looking(90, 0), 2) == glm::dvec3(0, -1, 0));

  REQUIRE(on_screen(looking(0, 90), 0) == glm::dvec3(1, 0, 0));
  REQUIRE(on_screen(looking(0, 90), 1) == glm::dvec3(0, -1, 0));
  REQUIRE(on_screen(looking(0, 90), 2) == glm::dvec3(0, 0, -1));  // +z is nearest

  REQUIRE(on_screen(looking(0, 0, 90), 0) == glm::dvec3(0, 1, 0));  // what was right is now below
  REQUIRE(on_screen(looking(0, 0, 90), 2) == glm::dvec3(1, 0, 0));  // what was above is now right

  // Between the axes: a viewer who has moved towards +x and up sees +x and +z come nearer.
  REQUIRE(on_screen(looking(30, 0), 0).z == Approx(-0.5));
  REQUIRE(on_screen(looking(0, 30), 2).z == Approx(-0.5));
  require_close(on_screen(looking(0, 0, 30), 0), {std::sqrt(0.75), 0.5, 0}, 1e-15);
}

TEST_CASE("axis-aligned views have exact zeros and every view is a rotation, not a mirror") {
  for (int a = -4; a <= 4; ++a)
    for (int e = -1; e <= 1; ++e)
      for (int r = 0; r < 4; ++r) {
        const auto view = make_view(looking(90 * a, 90 * e, 90 * r), cube, 64, 64);
        int zeros = 0;
        for (int k = 0; k < 3; ++k)
          for (int row = 0; row < 3; ++row) zeros += view.linear[k][row] == 0.0;
        REQUIRE(zeros == 6);
      }
  for (double a = -170; a < 190; a += 23)
    for (double e = -90; e <= 90; e += 18)
      for (double r = 0; r < 360; r += 41) {
        const auto view = make_view(looking(a, e, r), cube, 64, 64);
        const glm::dmat3 rotation = view.linear / view.pixels_per_unit;
        REQUIRE(glm::determinant(rotation) == Approx(1.0).epsilon(1e-14));
        const glm::dmat3 product = rotation * glm::transpose(rotation);
        for (int k = 0; k < 3; ++k)
          for (int row = 0; row < 3; ++row) REQUIRE(std::abs(product[k][row] - (k == row)) < 1e-15);
        require_close(glm::cross(view.right, view.up), view.to_viewer, 1e-15);
        require_close(rotation * view.right, {1, 0, 0}, 1e-15);
        require_close(rotation * view.up, {0, -1, 0}, 1e-15);
        require_close(rotation * view.to_viewer, {0, 0, -1}, 1e-15);
      }
}

TEST_CASE("zoom 1 fits the bounding sphere to the shorter side and centres the box") {
  LatticeFrame lattice{.dims = {7, 20, 3}, .spacing = {1.5, 0.25, 4.0}, .origin = {100, -3, 8}};
  const double radius = 0.5 * std::sqrt(7 * 1.5 * 7 * 1.5 + 20 * 0.25 * 20 * 0.25 + 3 * 4.0 * 3 * 4.0);
  for (const double zoom : {1.0, 0.5, 3.0}) {
    const auto view = make_view({.azimuth = 20, .elevation = 50, .zoom = zoom}, lattice, 640, 480);
    REQUIRE(view.pixels_per_unit == Approx(zoom * 240 / radius).epsilon(1e-15));
    require_close(view.project({3, 9.5, 1}), {320, 240, 0}, 1e-12);
    double farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p((corner & 1) ? 6.5 : -0.5, (corner & 2) ? 19.5 : -0.5, (corner & 4) ? 2.5 : -0.5);
      farthest = std::max(farthest, glm::length(view.project(p) - glm::dvec3(320, 240, 0)));
    }
    REQUIRE(farthest == Approx(240 * zoom).epsilon(1e-14));
  }
}

TEST_CASE("the direction matrix turns and mirrors the lattice in the world") {
  LatticeFrame lattice = cube;
  lattice.direction = glm::dmat3(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, -1));
  const auto view = make_view({}, lattice, 200, 200);
  REQUIRE(view.linear[0] == glm::dvec3(0, 0, view.pixels_per_unit));   // lattice x runs along world y
  REQUIRE(view.linear[1] == glm::dvec3(-view.pixels_per_unit, 0, 0));  // lattice y along world -x
  REQUIRE(view.linear[2] == glm::dvec3(0, view.pixels_per_unit, 0));   // lattice z along world -z
}

TEST_CASE("voxel sizes from 1e-12 to 1e12 and an origin of 1e9 give the same picture") {
  const Camera camera = looking(33, 21, 5);
  LatticeFrame lattice{.dims = {30, 40, 50}, .spacing = {1, 2, 0.5}};
  const auto expected = make_view(camera, lattice, 300, 200);
  for (const double size : {1e-12, 1e-3, 1e6, 1e12}) {
    LatticeFrame scaled = lattice;
    scaled.spacing *= size;
    scaled.origin = {1e9, -1e9, 1e9};
    const auto view = make_view(camera, scaled, 300, 200);
    for (int k = 0; k < 3; ++k) require_close(view.linear[k], expected.linear[k], 1e-14);
    require_close(view.offset, expected.offset, 1e-12);
    REQUIRE(view.pixels_per_unit * size == Approx(expected.pixels_per_unit).epsilon(1e-14));
  }
  LatticeFrame flat{.dims = {8, 8, 8}, .spacing = {1e-12, 1e12, 1.0}};
  const auto view = make_view({}, flat, 100, 100);
  REQUIRE(view.linear[0].x == Approx(1e-12 * view.pixels_per_unit));
}

TEST_CASE("a camera matrix maps world to pixels as it stands") {
  const LatticeFrame lattice{.dims = {9, 9, 9}, .spacing = {2, 3, 4}, .origin = {10, 20, 30}};
  const auto angles = make_view(looking(40, 25, 10), lattice, 320, 240);
  // The same view as a matrix: rows are scaled world directions, the translation puts the centre at the
  // middle.
  const double s = angles.pixels_per_unit;
  const glm::dvec3 rows[3] = {s * angles.right, -s * angles.up, -s * angles.to_viewer};
  const glm::dvec3 centre = lattice.origin + lattice.spacing * 4.0;
  const glm::dvec3 middle{160, 120, 0};
  std::array<double, 12> matrix{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t k = 0; k < 3; ++k) matrix[4 * r + k] = rows[r][int(k)];
    matrix[4 * r + 3] = middle[int(r)] - glm::dot(rows[r], centre);
  }
  const auto view = make_view({.matrix = matrix}, lattice, 320, 240);
  for (int k = 0; k < 3; ++k) require_close(view.linear[k], angles.linear[k], 1e-13);
  require_close(view.offset, angles.offset, 1e-11);
  require_close(view.right, angles.right, 1e-15);
  require_close(view.up, angles.up, 1e-15);
  require_close(view.to_viewer, angles.to_viewer, 1e-15);
  REQUIRE(view.pixels_per_unit == Approx(s).epsilon(1e-14));
}

TEST_CASE("a matrix may mirror, stretch and shear; its axes follow") {
  const auto mirrored =
      make_view({.matrix = std::array<double, 12>{-2, 0, 0, 50, 0, 0, -2, 50, 0, 2, 0, 0}}, cube, 9, 9);
  REQUIRE(mirrored.right == glm::dvec3(-1, 0, 0));
  REQUIRE(mirrored.up == glm::dvec3(0, 0, 1));
  REQUIRE(mirrored.to_viewer == glm::dvec3(0, -1, 0));
  REQUIRE(mirrored.pixels_per_unit == Approx(2.0));
  REQUIRE(mirrored.project({1, 2, 3}) == glm::dvec3(48, 44, 4));

  // x also moves the picture down: the direction that moves nothing but right is (1, 0, -1) / sqrt 2 ... down
  // by x + z.
  const auto sheared =
      make_view({.matrix = std::array<double, 12>{1, 0, 0, 0, 1, 0, 8, 0, 0, 0.001, 0, 0}}, cube, 9, 9);
  // rows: right = x, down = x + 8 z, depth = 0.001 y
  require_close(sheared.right, glm::normalize(glm::dvec3(8, 0, -1)), 1e-15);
  require_close(sheared.up, {0, 0, -1}, 1e-15);
  require_close(sheared.to_viewer, {0, -1, 0}, 1e-15);
  REQUIRE(sheared.pixels_per_unit == Approx(std::cbrt(0.008)));
}

TEST_CASE("a matrix composed with an origin of 1e9 keeps the picture's digits") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 1000; ++trial) {
    const glm::dvec3 origin{1e9 * number(random), 1e9 * number(random), 1e9 * number(random)};
    std::array<double, 12> m{};
    for (auto& v : m) v = number(random);
    long double exact[3];
    for (std::size_t r = 0; r < 3; ++r) {
      m[4 * r + 3] =
          -(m[4 * r] * origin.x + m[4 * r + 1] * origin.y + m[4 * r + 2] * origin.z) + 100 * number(random);
      exact[r] = m[4 * r + 3];
      for (std::size_t k = 0; k < 3; ++k) exact[r] += static_cast<long double>(m[4 * r + k]) * origin[int(k)];
    }
    const LatticeFrame lattice{.dims = glm::ivec3(64), .origin = origin};
    const auto view = make_view({.matrix = m}, lattice, 100, 100);
    for (int r = 0; r < 3; ++r) REQUIRE(std::abs(double(view.offset[r] - exact[r])) < 2e-10);
  }
}

TEST_CASE("bad cameras are refused with a message that names what is wrong") {
  const auto fails = [](const Camera& camera, int width, const std::string& words) {
    const std::string message = message_of([&] { make_view(camera, cube, width, 10); });
    CAPTURE(message, words);
    REQUIRE(says(message, words));
  };
  using Matrix = std::array<double, 12>;
  fails({.azimuth = nan_value}, 10, "azimuth");
  fails({.elevation = infinity}, 10, "elevation");
  fails({.roll = -infinity}, 10, "roll");
  for (const double zoom : {0.0, -1.0, nan_value, infinity}) fails({.zoom = zoom}, 10, "zoom");
  fails({.zoom = 1e308}, 10, "beyond double precision");
  fails({.zoom = 1e-320}, 10, "beyond double precision");
  for (const double pan : {nan_value, -infinity, 1e7}) fails({.pan = {0, pan}}, 10, "panned");
  fails({.matrix = Matrix{2, 0, 0, 0, 0, 0, -2, 0, 0, 2, 0, 0}, .pan = {1, 0}}, 10, "fourth column");
  fails({.eye = glm::dvec3(0, 0, nan_value)}, 10, "eye or target");
  fails({.eye = glm::dvec3(1, 2, 3), .target = glm::dvec3(1, 2, 3)}, 10, "where it looks");
  fails({.eye = glm::dvec3(0, 0, 30), .target = glm::dvec3(0)}, 10, "along its own up");
  fails({.fov = 40, .distance = 3, .eye = glm::dvec3(30, 0, 0)}, 10, "both given");
  fails({.up = glm::dvec3(0)}, 10, "up has no direction");
  fails({.matrix = Matrix{}}, 10, "singular");
  fails({.matrix = Matrix{1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0}}, 10, "singular");
  fails({.matrix = Matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}}, 10, "singular");
  fails({.matrix = Matrix{1, 0, 0, nan_value, 0, 1, 0, 0, 0, 0, 1, 0}}, 10, "not finite");
  fails({.matrix = Matrix{infinity, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}, 10, "not finite");
  fails({}, 0, "0 x 10 pixels");
  fails({}, -5, "-5 x 10 pixels");
}

TEST_CASE("a single voxel can be viewed") {
  const auto view = make_view({}, LatticeFrame{}, 100, 100);
  REQUIRE(view.project({0, 0, 0}) == glm::dvec3(50, 50, 0));
  REQUIRE(view.pixels_per_unit == Approx(100 / std::sqrt(3.0)));
}

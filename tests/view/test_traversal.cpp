#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <random>

#include "ringsplat/view/view.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

const LatticeFrame cube{.dims = glm::ivec3(16)};

Traversal traversal_of(const Camera& camera, const LatticeFrame& lattice = cube) {
  return choose_traversal(make_view(camera, lattice, 256, 256), lattice);
}

/// True when the slices' depths along the ray at one pixel increase in the traversal's order.
bool front_to_back(const ViewTransform& view, const Traversal& traversal, int slices) {
  // A slice's depth under a pixel is where the ray's lattice coordinate along the axis equals the slice.
  const glm::dmat3 inverse = glm::inverse(view.linear);
  const int k = int(traversal.axis);
  const glm::dvec3 start = inverse * (glm::dvec3(37.5, 121.5, 0) - view.offset);
  const glm::dvec3 ray = inverse[2];
  for (int step = 1; step < slices; ++step) {
    const double before = (traversal.slice_at(step - 1, slices) - start[k]) / ray[k];
    const double here = (traversal.slice_at(step, slices) - start[k]) / ray[k];
    if (!(here > before)) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("each axis-aligned view walks its axis from the viewer on") {
  const struct {
    double azimuth, elevation;
    Axis axis;
    bool ascending;
  } views[] = {{0, 0, Axis::y, true},   {90, 0, Axis::x, false},  {180, 0, Axis::y, false},
               {-90, 0, Axis::x, true}, {270, 0, Axis::x, true},  {0, 90, Axis::z, false},
               {0, -90, Axis::z, true}, {90, 90, Axis::z, false}, {123, -90, Axis::z, true}};
  for (const auto& v : views)
    for (const double roll : {0.0, 90.0, 17.0}) {
      INFO(v.azimuth << ' ' << v.elevation << ' ' << roll);
      const auto t = traversal_of({.azimuth = v.azimuth, .elevation = v.elevation, .roll = roll});
      REQUIRE(t.axis == v.axis);
      REQUIRE(t.ascending == v.ascending);
      REQUIRE(t.cos_angle == 1.0);
      REQUIRE(t.slice_distance == 1.0);
    }
}

TEST_CASE("ties go to z before y before x") {
  for (const double azimuth : {45.0, 135.0, 225.0, -45.0, 315.0})
    REQUIRE(traversal_of({.azimuth = azimuth}).axis == Axis::y);             // x and y
  REQUIRE(traversal_of({.elevation = 45}).axis == Axis::z);                  // y and z
  REQUIRE(traversal_of({.azimuth = 90, .elevation = -45}).axis == Axis::z);  // x and z
  const double diagonal = std::atan(std::sqrt(0.5)) * 180 / std::acos(-1.0);
  const auto three = traversal_of({.azimuth = 45, .elevation = diagonal});
  REQUIRE(three.axis == Axis::z);
  REQUIRE(three.cos_angle == Approx(1 / std::sqrt(3.0)).epsilon(1e-12));
  REQUIRE(three.slice_distance == Approx(std::sqrt(3.0)).epsilon(1e-12));
  // Beyond the tolerance the larger |cos| wins, whatever the axis.
  REQUIRE(traversal_of({.azimuth = 45 + 1e-6}).axis == Axis::x);
  REQUIRE(traversal_of({.azimuth = 45 - 1e-6}).axis == Axis::y);
  REQUIRE(traversal_of({.azimuth = 45 + 1e-8}).axis == Axis::y);  // |cos| differ by 3.5e-10
  REQUIRE(traversal_of({.elevation = 45 - 1e-6}).axis == Axis::y);
}

TEST_CASE("anisotropic voxels: the angle is the world's, the distance is in smallest spacings") {
  const LatticeFrame flat{.dims = {64, 64, 20}, .spacing = {0.5, 0.5, 2.5}};
  // 40 degrees above the horizon: y slices face the viewer more than z slices do, whatever the spacing.
  auto t = traversal_of({.elevation = 40}, flat);
  REQUIRE(t.axis == Axis::y);
  REQUIRE(t.cos_angle == Approx(std::cos(40 * std::acos(-1.0) / 180)).epsilon(1e-14));
  REQUIRE(t.slice_distance == Approx(1 / t.cos_angle).epsilon(1e-14));
  t = traversal_of({.elevation = 50}, flat);
  REQUIRE(t.axis == Axis::z);
  REQUIRE(t.slice_distance == Approx(5 / std::sin(50 * std::acos(-1.0) / 180)).epsilon(1e-14));
  for (const double size : {1e-12, 1e12}) {
    LatticeFrame scaled = flat;
    scaled.spacing *= size;
    REQUIRE(traversal_of({.elevation = 50}, scaled).slice_distance ==
            Approx(t.slice_distance).epsilon(1e-13));
  }
  const LatticeFrame extreme{.dims = {8, 8, 8}, .spacing = {1e-12, 1e12, 1}};
  t = traversal_of({.elevation = 90}, extreme);
  REQUIRE(t.axis == Axis::z);
  REQUIRE(t.slice_distance == 1e12);
}

TEST_CASE("the set that a ray crosses most goes by spacing, and takes more slabs where they are long") {
  const auto crossed = [](const Camera& camera, const LatticeFrame& lattice) {
    return choose_traversal(make_view(camera, lattice, 256, 256), lattice, SliceRule::most_crossed);
  };
  const LatticeFrame flat{.dims = {64, 64, 20}, .spacing = {1, 1, 10}};
  // z slices are crossed nearly as often as y slices where the slope is 8, at 82.9 degrees.
  for (const double degrees : {0.0, 30.0, 50.0, 75.0, 82.0})
    CHECK(crossed({.elevation = degrees}, flat).axis == Axis::y);
  for (const double degrees : {83.5, 90.0}) CHECK(crossed({.elevation = degrees}, flat).axis == Axis::z);
  const LatticeFrame rods{.dims = {8, 64, 64}, .spacing = {10, 1, 1}};
  CHECK(crossed({.azimuth = 82}, rods).axis == Axis::y);
  CHECK(crossed({.azimuth = 84}, rods).axis == Axis::x);

  CHECK(crossed({}, flat).slabs_for(3) == 3);
  CHECK(crossed({.elevation = 60}, flat).slabs_for(3) == 3);
  CHECK(crossed({.elevation = 84}, flat).slabs_for(3) == 8);
  CHECK(crossed({.elevation = 84}, flat).slabs_for(1) == 6);
  CHECK(crossed({.elevation = 90}, flat).slabs_for(1) == 4);
  // Where spacings are equal both rules agree, and as many slabs are taken as are asked for.
  for (double azimuth = 0; azimuth <= 90; azimuth += 7.5)
    for (double elevation = 0; elevation <= 90; elevation += 7.5) {
      const Traversal t = crossed({.azimuth = azimuth, .elevation = elevation}, cube);
      CHECK(t.axis == traversal_of({.azimuth = azimuth, .elevation = elevation}).axis);
      for (int slabs = 1; slabs <= 4; ++slabs) CHECK(t.slabs_for(slabs) == slabs);
    }
}

TEST_CASE("a mirrored lattice is walked the other way") {
  LatticeFrame mirrored = cube;
  mirrored.direction[1] = {0, -1, 0};
  const auto t = traversal_of({}, mirrored);
  REQUIRE(t.axis == Axis::y);
  REQUIRE_FALSE(t.ascending);
  // A camera that mirrors the picture changes neither axis nor order.
  const auto m = traversal_of({.matrix = std::array<double, 12>{-2, 0, 0, 50, 0, 0, -2, 50, 0, 2, 0, 0}});
  REQUIRE(m.axis == Axis::y);
  REQUIRE(m.ascending);
  REQUIRE(m.slice_distance == 1.0);
}

TEST_CASE("the depth scale of a matrix changes neither the axis' order nor the world distance") {
  const std::array<double, 12> thin{3, 0, 0, 0, 0, 0, -3, 0, 0, 1e-3, 0, 0};
  const auto t = traversal_of({.matrix = thin});
  REQUIRE(t.axis == Axis::y);
  REQUIRE(t.ascending);
  REQUIRE(t.slice_distance == 1.0);
}

TEST_CASE("any view walks any lattice front to back, on the axis of the largest cosine") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> angle(-180, 180), exponent(-2, 2), number(-1, 1);
  for (int trial = 0; trial < 5000; ++trial) {
    LatticeFrame lattice{.dims = {16, 16, 16}};
    for (int k = 0; k < 3; ++k) lattice.spacing[k] = std::pow(10, exponent(random));
    Camera camera{.azimuth = angle(random), .elevation = angle(random) / 2, .roll = angle(random)};
    if (trial % 3 == 1) lattice.direction[trial % 2] *= -1.0;
    if (trial % 3 == 2)  // oblique, as of a tilted gantry
      lattice.direction[2] = glm::normalize(glm::dvec3(0.4 * number(random), 0.4 * number(random), 1));
    if (trial % 5 == 0) {
      camera.matrix.emplace();
      for (auto& v : *camera.matrix) v = number(random);
    }
    const auto view = make_view(camera, lattice, 256, 256);
    const auto t = choose_traversal(view, lattice);
    REQUIRE(front_to_back(view, t, 16));

    // Computed independently: a slice's normal on the screen is the cross product of its two in-plane steps.
    double cosines[3];
    for (int k = 0; k < 3; ++k) {
      const auto [u, v] = in_plane(Axis(k));
      cosines[k] = std::abs(
          glm::normalize(glm::cross(glm::normalize(view.linear[u]), glm::normalize(view.linear[v]))).z);
    }
    REQUIRE(t.cos_angle == Approx(*std::max_element(cosines, cosines + 3)).epsilon(1e-8));
    REQUIRE(t.cos_angle == Approx(cosines[int(t.axis)]).epsilon(1e-8));
    const double smallest = std::min({lattice.spacing.x, lattice.spacing.y, lattice.spacing.z});
    if (trial % 5 != 0) {
      // Computed in the world: the ray's length between two planes.
      const auto [u, v] = in_plane(t.axis);
      const glm::dvec3 normal = glm::normalize(glm::cross(lattice.direction[u], lattice.direction[v])),
                       step = lattice.spacing[int(t.axis)] * lattice.direction[int(t.axis)];
      REQUIRE(t.slice_distance ==
              Approx(std::abs(glm::dot(normal, step) / glm::dot(normal, view.to_viewer)) / smallest)
                  .epsilon(1e-8));
    }
    if (trial % 3 != 2 && trial % 5 != 0) {
      REQUIRE(t.cos_angle >= 1 / std::sqrt(3.0) - 1e-12);
      REQUIRE(t.slice_distance ==
              Approx(lattice.spacing[int(t.axis)] / smallest / t.cos_angle).epsilon(1e-10));
    }
  }
}

// What zoom 1 fits: the volume's box as it is seen, or its bounding sphere.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <random>

#include "ringsplat/view/view.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// A lattice that is anisotropic, oblique and far from the origin.
LatticeFrame tilted() {
  LatticeFrame lattice{.dims = {40, 24, 9}, .spacing = {0.5, 0.8, 3}, .origin = {100, -200, 50}};
  lattice.direction[2] = glm::normalize(glm::dvec3(0.3, -0.4, 1.0));
  return lattice;
}

struct Extent {
  double width = 0, height = 0;
};

/// How much of the picture's half width and half height the box's corners take, from its middle.
Extent taken_by_box(const ViewTransform& view, const LatticeFrame& lattice, int width, int height) {
  Extent most;
  for (int c = 0; c < 8; ++c) {
    const glm::dvec3 corner = glm::dvec3(c & 1, c >> 1 & 1, c >> 2) * glm::dvec3(lattice.dims) - 0.5;
    const glm::dvec2 seen = view.seen_at(corner);
    most.width = std::max(most.width, std::abs(seen.x / (0.5 * width) - 1));
    most.height = std::max(most.height, std::abs(seen.y / (0.5 * height) - 1));
  }
  return most;
}

struct Picture {
  Camera camera;
  int width, height;
};

std::vector<Picture> random_pictures(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-180, 180);
  std::uniform_int_distribution<int> pixels(50, 500);
  std::vector<Picture> all;
  for (int k = 0; k < count; ++k)
    all.push_back({{.azimuth = angle(random),
                    .elevation = angle(random),
                    .roll = angle(random),
                    .fov = k % 3 == 0 ? 0.0 : 60 + angle(random) / 4,
                    .fit = Fit::box},
                   pixels(random),
                   pixels(random)});
  return all;
}

}  // namespace

TEST_CASE("a fitted box just fills its part of the picture, from anywhere, in a picture of any shape") {
  const LatticeFrame lattice = tilted();
  for (const auto& [camera, width, height] : random_pictures(300)) {
    INFO(camera.azimuth << ' ' << camera.elevation << ' ' << camera.roll << ' ' << camera.fov << ' ' << width
                        << 'x' << height);
    const Extent taken = taken_by_box(make_view(camera, lattice, width, height), lattice, width, height);
    REQUIRE(std::max(taken.width, taken.height) == Approx(box_fill).epsilon(1e-9));
  }
}

TEST_CASE("a flat box fills the width that a sphere about it leaves empty") {
  const LatticeFrame flat{.dims = {256, 256, 32}};
  const ViewTransform front = make_view({.fit = Fit::box}, flat, 512, 128);
  CHECK(front.pixels_per_unit == Approx(box_fill * 512 / 256));
  CHECK(make_view({}, flat, 512, 128).pixels_per_unit < 0.4);
}

TEST_CASE("zoom, pan and target move and scale a fitted picture, and change nothing else") {
  const LatticeFrame lattice = tilted();
  const glm::dvec3 target = lattice.origin + lattice.direction * (lattice.spacing * glm::dvec3(30, 5, 6));
  for (auto [camera, width, height] : random_pictures(60)) {
    const ViewTransform plain = make_view(camera, lattice, width, height);
    Camera other = camera;
    other.zoom = 3;
    CHECK(make_view(other, lattice, width, height).pixels_per_unit == Approx(3 * plain.pixels_per_unit));
    other = camera;
    other.pan = {0.2, -0.4};
    CHECK(make_view(other, lattice, width, height).pixels_per_unit == plain.pixels_per_unit);
    other.target = target;
    const ViewTransform aimed = make_view(other, lattice, width, height);
    if (!plain.eye) {
      CHECK(aimed.pixels_per_unit == Approx(plain.pixels_per_unit));
      continue;
    }
    // The eye goes sideways only.
    const auto towards = [&](const glm::dvec3& eye) {
      return glm::dot(lattice.direction * (lattice.spacing * eye), plain.to_viewer);
    };
    CHECK(towards(*aimed.eye) == Approx(towards(*plain.eye)));
  }
}

TEST_CASE("an eye that looks at a far corner of a fitted box stays outside of it") {
  const LatticeFrame cube{.dims = glm::ivec3(11)};
  for (const double where : {-40.0, 0.0, 10.0, 60.0}) {
    const Camera camera{.fov = 120, .target = glm::dvec3(5, where, 5), .fit = Fit::box};
    const ViewTransform view = make_view(camera, cube, 100, 100);
    CHECK(view.eye->y < -0.5);
    CHECK_NOTHROW(choose_traversal(view, cube));
  }
}

TEST_CASE("a distance, an eye in perspective and a matrix leave nothing to fit") {
  const LatticeFrame lattice = tilted();
  const auto same = [&](Camera camera) {
    const ViewTransform sphere = make_view(camera, lattice, 200, 90);
    camera.fit = Fit::box;
    const ViewTransform box = make_view(camera, lattice, 200, 90);
    return box.linear == sphere.linear && box.offset == sphere.offset && box.eye == sphere.eye;
  };
  CHECK(same({.azimuth = 20, .fov = 40, .distance = 4}));
  CHECK(same({.fov = 40, .eye = glm::dvec3(100, -300, 60)}));
  CHECK(same({.matrix = std::array<double, 12>{2, 0, 0, 5, 0, 2, 0, 6, 0, 0, 2, 7}}));
  CHECK_FALSE(same({.eye = glm::dvec3(100, -300, 60)}));
  CHECK_FALSE(same({.fov = 40}));
}

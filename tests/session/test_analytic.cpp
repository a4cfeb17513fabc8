#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "frame/frame_geometry.hpp"
#include "splat/footprint.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

TEST_CASE("a constant slab's opacity is 1 - (1 - a)^d, at any angle") {
  // 64 x 64 x 9 voxels of opacity 0.05; away from the border a ray crosses 9 slices, each 1/cos apart.
  const double alpha = 0.05;
  const auto source = synth_source("constant", make_grid({65, 65, 9}));
  FrameSpec spec{.how = Splats{}};
  spec.shown.shading = Shading::none;
  spec.shown.transfer_function = constant_opacity(alpha);
  spec.shown.width = spec.shown.height = 384;
  spec.shown.camera.zoom = 2;
  const double cos3 = 1 / std::sqrt(3.0);
  for (const double angle : {0.0, 30.0, std::acos(cos3) * 180 / M_PI}) {
    spec.shown.camera.azimuth = 45;  // at 54.7 degrees all three axes tie, and z is taken
    spec.shown.camera.elevation = 90 - angle;
    const FrameResult result = render_loopback(*source, spec, 2, 2);
    REQUIRE(result.axis == Axis::z);
    const double distance = 9 / std::cos(angle * M_PI / 180);
    const double truth = 1 - std::pow(1 - alpha, distance);
    double mean = 0;
    const int reach = 16;
    for (int y = -reach; y < reach; ++y)
      for (int x = -reach; x < reach; ++x) mean += double(result.image.pixel(192 + x, 192 + y)[3]);
    mean /= 4.0 * reach * reach;
    INFO("angle " << angle);
    CHECK(std::abs(mean - truth) < 0.005 * truth);
  }
}

TEST_CASE("one voxel gives exactly the quartic") {
  const auto source = synth_source("point", make_grid({9, 9, 9}, ScalarType::float32));
  FrameSpec spec{.how = Splats{}};
  spec.shown.shading = Shading::none;
  spec.shown.transfer_function = constant_opacity(0.5, 0.5);
  spec.shown.width = spec.shown.height = 256;
  spec.shown.camera = {.azimuth = 25, .elevation = 35, .roll = 10, .zoom = 1};
  const FrameResult result = render_loopback(*source, spec, 1, 1);
  const FrameGeometry g = make_geometry(spec, source->grid());
  const Footprint footprint = make_footprint(g.view, g.traversal.axis, spec.as<Splats>().kernel_radius);
  const glm::dvec3 centre = g.view.project(glm::dvec3(4));
  const double opacity = 1 - std::pow(0.5, g.traversal.slice_distance);
  double largest = 0, peak = 0;
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      const glm::dvec2 r = footprint.p * (glm::dvec2(x + 0.5, y + 0.5) - glm::dvec2(centre));
      const double q = std::max(0.0, 1 - glm::dot(r, r));
      const double expected = q * q * opacity * footprint.weight;
      largest = std::max(largest, std::abs(double(result.image.pixel(x, y)[3]) - expected));
      peak = std::max(peak, expected);
    }
  CHECK(peak > 0.15);
  CHECK(largest < 2e-7);
}

TEST_CASE("the picture is right-handed") {
  // A voxel of the +x, +y, +z corner region, seen from the front (along +y): right of and above the middle.
  const Grid grid = make_grid({9, 9, 9});
  std::vector<std::byte> voxels(grid.voxels());
  voxels[8 + 9 * (4 + 9 * std::size_t(6))] = std::byte{255};  // x = 8 (far right), y = 4, z = 6 (upper)
  const auto source = memory_source(grid, voxels);
  FrameSpec spec{.how = Splats{}};
  spec.shown.shading = Shading::none;
  spec.shown.transfer_function = constant_opacity(0.9, 100);
  spec.shown.width = spec.shown.height = 90;
  const Image image = render_loopback(*source, spec, 1, 1).image;
  double x_sum = 0, y_sum = 0, sum = 0;
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 90; ++x) {
      const double a = double(image.pixel(x, y)[3]);
      x_sum += a * (x + 0.5 - 45);
      y_sum += a * (y + 0.5 - 45);
      sum += a;
    }
  REQUIRE(sum > 0);
  const double scale = 90 / std::sqrt(3 * 81.0);  // pixels a voxel: the bounding sphere fits the picture
  CHECK(x_sum / sum == Approx(4 * scale).epsilon(0.01));
  CHECK(y_sum / sum == Approx(-2 * scale).epsilon(0.01));
}

TEST_CASE("a volume of odd shape is drawn: single voxel, line, plane") {
  for (const glm::ivec3 dims :
       {glm::ivec3(1, 1, 1), glm::ivec3(1, 20, 20), glm::ivec3(20, 1, 1), glm::ivec3(20, 20, 1)}) {
    const auto source = synth_source("constant", make_grid(dims));
    FrameSpec spec{.how = Splats{}};
    spec.shown.transfer_function = constant_opacity(0.5);
    spec.shown.width = spec.shown.height = 64;
    spec.shown.camera = {.azimuth = 40, .elevation = 20, .roll = 0, .zoom = 1};
    const FrameResult result = render_loopback(*source, spec, 3, 2);
    INFO(dims.x << " x " << dims.y << " x " << dims.z);
    CHECK(brightest(result.image) > 0.1F);
    CHECK(result.stats.total().visible_voxels == std::uint64_t(source->grid().voxels()));
  }
}

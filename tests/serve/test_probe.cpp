#include "serve/probe.hpp"

#include <cmath>
#include <glm/geometric.hpp>

#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::serve;

namespace {

constexpr int side = 32;

/// A ball whose values fall from 250 at its centre to 0.
double ball(const glm::dvec3& p) { return std::max(0.0, 250 - 15 * glm::distance(p, glm::dvec3(15.5))); }

Grid grid() {
  Grid g;
  g.dims = glm::ivec3(side);
  g.spacing = {1, 1.5, 2};
  g.origin = {5, 6, 7};
  return g;
}

std::vector<std::uint8_t> voxels() {
  std::vector<std::uint8_t> values;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) values.push_back(static_cast<std::uint8_t>(ball({x, y, z})));
  return values;
}

FrameSpec view(double azimuth, double elevation) {
  FrameSpec spec;
  spec.how = Sheets{};
  spec.shown.width = 120;
  spec.shown.height = 100;
  spec.shown.camera = {.azimuth = azimuth, .elevation = elevation, .zoom = 1.3, .pan = {0.05, -0.1}};
  spec.shown.transfer_function = {.name = "step",
                                  .colours = {{0, glm::dvec3(1.0)}, {250, glm::dvec3(1.0)}},
                                  .opacities = {{0, 0}, {99.5, 0}, {100.5, 1}, {250, 1}}};
  return spec;
}

Image render(const FrameSpec& spec) {
  const auto values = voxels();
  return test::render_loopback(*memory_source(grid(), std::as_bytes(std::span(values))), spec, 1, 1).image;
}

Probed probe(const FrameSpec& spec, double x, double y) {
  ValueRange range;
  const auto values = voxels();
  range.add(ScalarType::uint8, std::as_bytes(std::span(values)));
  Probe all(spec, grid(), std::floor(x) + 0.5, std::floor(y) + 0.5);
  all.know_range(range);
  while (const auto frame = all.next_frame()) {
    FrameSpec one = *frame;
    one.frame = 0;
    all.take(render(one));
  }
  return all.answer();
}

}  // namespace

TEST_CASE("The picture of one pixel is that pixel of the whole picture") {
  const Fit fit = GENERATE(Fit::sphere, Fit::box);
  FrameSpec spec = view(30, 20);
  spec.shown.camera.fit = fit;
  const Image whole = render(spec);
  for (const auto& [x, y] : {std::pair{60, 50}, {40, 42}, {71, 60}, {2, 3}}) {
    FrameSpec one = spec;
    one.shown.camera = camera_of_pixel(spec.shown.camera, lattice_frame(grid()), 120, 100, x + 0.5, y + 0.5);
    one.shown.width = one.shown.height = 1;
    const Image pixel = render(one);
    for (int c = 0; c < 4; ++c) CHECK(std::abs(pixel.rgba[std::size_t(c)] - whole.pixel(x, y)[c]) < 0.01F);
  }
}

TEST_CASE("A probe finds the surface under a pixel and the value there") {
  for (const auto& [azimuth, elevation] :
       {std::pair{0.0, 0.0}, {30.0, 20.0}, {90.0, 0.0}, {180.0, -40.0}, {0.0, 90.0}}) {
    const FrameSpec spec = view(azimuth, elevation);
    const ViewTransform seen = make_view(
        spec.shown.camera, {grid().dims, grid().spacing, grid().origin, grid().direction}, 120, 100);
    const glm::dvec3 centre = seen.project(glm::dvec3(15.5));
    const Probed probed = probe(spec, centre.x + 3, centre.y - 4);
    REQUIRE(probed.hit);
    // On the pixel's ray, on the side of the viewer, where the values are 100.
    const glm::dvec3 back = seen.project(probed.voxel);
    CHECK(std::abs(back.x - (std::floor(centre.x + 3) + 0.5)) < 0.01);
    CHECK(std::abs(back.y - (std::floor(centre.y - 4) + 0.5)) < 0.01);
    CHECK(back.z < centre.z);
    CHECK(std::abs(ball(probed.voxel) - 100) < 5);
    CHECK(std::abs(probed.value - 100) < 3);
    const glm::dvec3 world = grid().origin + grid().spacing * probed.voxel;
    CHECK(glm::distance(world, probed.world) < 1e-9);
  }
}

TEST_CASE("In a mode without light a probe finds the place and value that decide on the pixel") {
  FrameSpec spec = view(30, 20);
  spec.shown.transfer_function.opacities = {{0, 1}, {250, 1}};
  for (const Mode mode : {Mode::mip, Mode::sum}) {
    spec.shown.mode = mode;
    const Probed p = probe(spec, 60, 42);
    REQUIRE(p.hit);
    // The ball's values are largest where the ray is nearest to its centre.
    CHECK(p.value == Approx(ball(p.voxel)).margin(12));
    // Nowhere on the pixel's ray is it larger than there: so says the picture of the largest values.
    spec.shown.mode = Mode::mip;
    spec.shown.transfer_function.colours = {{0, glm::dvec3(0.0)}, {250, glm::dvec3(1.0)}};
    const Image picture = render(spec);
    CHECK(p.value == Approx(250 * picture.pixel(60, 42)[0]).margin(0.1));
  }
}

TEST_CASE("A probe of a volume that is cut open finds the cut, and beside it the surface behind") {
  FrameSpec spec = view(0, 30);
  spec.shown.cut = ClipPlane{{0, 0, -1}, 2};  // a voxel below the middle; the ball reaches farther down
  const ViewTransform seen =
      make_view(spec.shown.camera, {grid().dims, grid().spacing, grid().origin, grid().direction}, 120, 100);
  const glm::dvec3 at = {18, 14, 14.5}, pixel = seen.project(at);
  const Probed probed = probe(spec, pixel.x, pixel.y);
  REQUIRE(probed.hit);
  CHECK(glm::distance(probed.voxel, at) < 0.5);
  CHECK(probed.voxel.z == Approx(14.5));
  CHECK(probed.value == Approx(ball(probed.voxel)).margin(3));
  const glm::dvec3 below = seen.project({15.5, 0, 8});  // in front of the ball, under the cut
  const Probed behind = probe(spec, below.x, below.y);
  CHECK((!behind.hit || behind.voxel.z < 14.4));
}

TEST_CASE("A probe goes on where the cut is clear") {
  FrameSpec spec = view(0, 30);
  spec.shown.cut = ClipPlane{{0, 0, -1}, 2};
  spec.shown.interpolation = Interpolation::nearest;
  spec.shown.transfer_function.opacities = {{0, 0}, {99, 0}, {100, 1}, {250, 1}};
  const ViewTransform seen =
      make_view(spec.shown.camera, {grid().dims, grid().spacing, grid().origin, grid().direction}, 120, 100);
  const glm::dvec3 beside = seen.project({15.5, 1, 14.5}), inside = seen.project({15.5, 15.5, 14.5});
  CHECK(probe(spec, inside.x, inside.y).voxel.z == Approx(14.5));
  const Probed behind = probe(spec, beside.x, beside.y);
  CHECK((!behind.hit || behind.voxel.z < 14.4));
}

TEST_CASE("A probe beside the volume hits nothing") {
  const Probed probed = probe(view(30, 20), 1, 1);
  CHECK(!probed.hit);
}

TEST_CASE("A probe knows the clip box") {
  FrameSpec spec = view(0, 0);
  spec.shown.clip = VoxelBox{{0, 14, 0}, {side, side, side}};
  const ViewTransform seen =
      make_view(spec.shown.camera, {grid().dims, grid().spacing, grid().origin, grid().direction}, 120, 100);
  const glm::dvec3 centre = seen.project(glm::dvec3(15.5));
  const Probed probed = probe(spec, centre.x, centre.y);
  REQUIRE(probed.hit);
  CHECK(std::abs(probed.voxel.y - 14) < 1);
  CHECK(std::abs(probed.value - ball({15.5, 14, 15.5})) < 8);
}

TEST_CASE("A probe sees what an eye sees that stands in the part of the volume that is cut off") {
  FrameSpec spec = view(0, 0);
  const Grid g = grid();
  spec.shown.clip = VoxelBox{{0, 14, 0}, {side, side, side}};
  spec.shown.camera = {.fov = 60,
                       .eye = g.origin + g.spacing * glm::dvec3(15.5, 6, 15.5),
                       .target = g.origin + g.spacing * glm::dvec3(15.5)};
  const Probed probed = probe(spec, 60, 50);
  REQUIRE(probed.hit);
  CHECK(std::abs(probed.voxel.y - 14) < 1);
  CHECK(std::abs(probed.value - ball({15.5, 14, 15.5})) < 8);
}

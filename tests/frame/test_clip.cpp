#include "frame/frame_geometry.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

namespace {

Grid volume() {
  Grid grid;
  grid.dims = {64, 48, 80};
  grid.spacing = {1, 1.5, 0.75};
  grid.origin = {-20, 11, 3};
  return grid;
}

FrameSpec view(const Camera& camera) {
  FrameSpec spec;
  spec.how = Sheets{};
  spec.shown.camera = camera;
  spec.shown.width = spec.shown.height = 200;
  spec.shown.transfer_function = {
      .name = "ramp", .colours = {{0, glm::dvec3(0.0)}, {1, glm::dvec3(1.0)}}, .opacities = {{0, 0}, {1, 1}}};
  return spec;
}

double apart(const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 d = glm::abs(a - b);
  return std::max({d.x, d.y, d.z});
}

}  // namespace

TEST_CASE("a clip box moves no voxel in the picture, and no pixel outside of it is dealt") {
  const Grid grid = volume();
  const VoxelBox box{{10, 7, 33}, {25, 20, 50}};
  for (const int factor : {1, 2, 4})
    for (const bool prefilter : {false, true})
      for (const double fov : {0.0, 40.0}) {
        FrameSpec spec = view({.azimuth = 30, .elevation = 20, .fov = fov});
        spec.shown.reduction = {factor, prefilter};
        const FrameGeometry whole = make_geometry(spec, grid);
        CHECK(whole.box == whole_box(whole.grid));
        spec.shown.clip = box;
        const FrameGeometry part = make_geometry(spec, grid);
        CHECK(part.box == reduced_box(box, grid, spec.shown.reduction));
        CHECK(part.grid.dims == part.box.dims());
        CHECK(part.slices == part.grid.slices(part.traversal.axis));
        CHECK(part.traversal.axis == whole.traversal.axis);
        CHECK(part.traversal.slice_distance == whole.traversal.slice_distance);
        const glm::dvec3 first(part.box.first), corner(3, 5, 1);
        CHECK(apart(part.view.project(corner), whole.view.project(first + corner)) < 1e-10);
        if (fov > 0) CHECK(apart(*part.view.eye + first, *whole.view.eye) < 1e-12);
        CHECK(apart(part.grid.origin,
                    whole.grid.origin + whole.grid.direction * (whole.grid.spacing * first)) < 1e-12);
        CHECK(part.reached.width() * part.reached.height() <= whole.reached.width() * whole.reached.height());
      }
}

TEST_CASE("the eye may lie within the volume where the clip box leaves it room, and all agree on the axis") {
  const Grid grid = volume();
  // The eye lies half a radius before the middle, within the volume.
  FrameSpec spec = view({.azimuth = 0, .elevation = 0, .fov = 60, .distance = 0.5});
  CHECK(says(message_of([&] { make_geometry(spec, grid); }), "inside the volume"));
  CHECK_THROWS_AS(traversed_axis(spec, grid), InputError);
  spec.shown.clip = VoxelBox{{0, 24, 0}, {64, 48, 80}};
  const FrameGeometry g = make_geometry(spec, grid);
  CHECK(g.traversal.axis == Axis::y);
  CHECK(g.traversal.ascending);
  CHECK(traversed_axis(spec, grid) == Axis::y);
  spec.shown.clip = VoxelBox{{0, 0, 0}, {64, 30, 80}};
  CHECK(says(message_of([&] { make_geometry(spec, grid); }), "inside the volume"));
}

TEST_CASE("the axis to load is asked with the box that is drawn") {
  const Grid grid = volume();
  FrameSpec spec{.how = Splats{}};
  spec.shown.clip = VoxelBox{{0, 0, 0}, {64, 49, 80}};
  CHECK(says(message_of([&] { traversed_axis(spec, grid); }), "y part, 0:49"));
}

#include <cmath>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// No field has its default value.
FrameSpec unusual_spec() {
  FrameSpec spec{.how = Splats{}};
  spec.frame = 1LL << 40;
  spec.shown.camera = {.azimuth = 1.0 / 3,
                       .elevation = -21,
                       .roll = 8,
                       .zoom = 1.2,
                       .matrix = {{1, 2, 3}},
                       .fov = 40,
                       .distance = 3,
                       .pan = {0.5, -2},
                       .eye = glm::dvec3(7, 8, 9),
                       .target = glm::dvec3(-1, 2, 3),
                       .up = {0, 1, 0},
                       .fit = Fit::box};
  spec.shown.width = 120;
  spec.shown.height = 104;
  spec.as<Splats>().image_plane = ImagePlane::slices;
  spec.as<Splats>().plane_samples = 4;
  spec.division.region_size = 32;
  spec.division.dealt_to = 7;
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  spec.shown.transfer_function.name = "bone, thin";
  spec.shown.transfer_function.nan_srgb = {0, 0.25, 1};
  spec.shown.interpolation = Interpolation::nearest;
  spec.shown.shading = Shading::none;
  spec.shown.material = {.ambient = 0.125, .diffuse = 0.5, .specular = 0.75, .exponent = 3};
  spec.shown.light = {1, 2, 3};
  spec.as<Splats>().kernel_radius = 1.25;
  spec.shown.opacity_correction = false;
  spec.shown.opaque_threshold = 0;
  spec.shown.reduction = {.factor = 2, .prefilter = true};
  spec.shown.clip = VoxelBox{{1, 2, 3}, {40, 50, 60}};
  spec.shown.clip_planes = {{{1, -2, 0.5}, 12.5}};
  spec.shown.edges = EdgeOpacity{0.5, 20};
  return spec;
}

}  // namespace

TEST_CASE("an announced frame arrives as it was sent, field by field") {
  CHECK(decode_frame_spec(encode(FrameSpec())) == FrameSpec());
  const FrameSpec spec = unusual_spec(), arrived = decode_frame_spec(encode(spec));
  CHECK(arrived == spec);
  CHECK(to_json(arrived) == to_json(spec));
}

TEST_CASE("bytes that are no frame announcement are refused, whatever their length") {
  const Bytes whole = encode(unusual_spec());
  for (std::size_t count = 0; count < whole.size(); ++count)
    REQUIRE_THROWS_AS(decode_frame_spec(std::span(whole).first(count)), RunError);
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  REQUIRE_THROWS_AS(decode_frame_spec(longer), RunError);
  REQUIRE_THROWS_AS(decode_frame_spec(Bytes(whole.size(), std::byte{0xff})), RunError);
  CHECK(method_of(whole).index() == unusual_spec().how.index());
  for (const Bytes& other : {Bytes(), Bytes(whole.size(), std::byte{7})})
    REQUIRE_THROWS_AS(method_of(other), RunError);
  for (const int unknown : {-1, 2, 1 << 30}) {
    FrameSpec odd = unusual_spec();
    odd.as<Splats>().image_plane = static_cast<ImagePlane>(unknown);
    REQUIRE_THROWS_AS(decode_frame_spec(encode(odd)), RunError);
  }
}

TEST_CASE("splats refuse perspective") {
  FrameSpec spec{.how = Splats{}};
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  spec.shown.camera.fov = 40;
  CHECK(message_of([&] { check(spec); }).find("--engine sheets") != std::string::npos);
  CHECK_THROWS_AS(make_geometry(spec, make_grid(glm::ivec3(8))), InputError);
  spec.how = Sheets{};
  check(spec);
  CHECK(make_geometry(spec, make_grid(glm::ivec3(8))).view.eye);
  CHECK(to_json(spec).at("camera").at("fov") == 40);
}

TEST_CASE("a reduced volume in perspective is seen from the same place") {
  FrameSpec spec;
  spec.how = Sheets{};
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  spec.shown.camera = {.azimuth = 31, .elevation = 17, .fov = 60};
  const FrameGeometry whole = make_geometry(spec, make_grid({17, 20, 23}));
  for (const bool prefilter : {false, true}) {
    spec.shown.reduction = {4, prefilter};
    const FrameGeometry reduced = make_geometry(spec, make_grid({17, 20, 23}));
    const double shift = prefilter ? 1.5 : 0.0;
    for (const glm::dvec3& p : {glm::dvec3(0, 0, 0), {3, 1, 2}, {4, 5, 0}}) {
      const glm::dvec2 expected = whole.view.seen_at(4.0 * p + shift), found = reduced.view.seen_at(p);
      CHECK(found.x == Approx(expected.x));
      CHECK(found.y == Approx(expected.y));
    }
    CHECK(reduced.traversal.axis == whole.traversal.axis);
    CHECK(reduced.traversal.slice_distance == Approx(4 * whole.traversal.slice_distance));
  }
}

TEST_CASE("an eye among the slices of the reduced volume only is refused") {
  FrameSpec spec;
  spec.how = Sheets{};
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  // A voxel before slice 0, where four-fold voxels still reach.
  spec.shown.camera = {.azimuth = 90, .elevation = -80, .fov = 60, .distance = 1.055};
  const Grid rod = make_grid({2, 2, 20});
  CHECK(make_geometry(spec, rod).traversal.axis == Axis::z);
  spec.shown.reduction = {4, false};
  CHECK(message_of([&] { make_geometry(spec, rod); }).find("undersampled") != std::string::npos);
}

TEST_CASE("the regions reached in perspective hold every point of the volume's box") {
  FrameSpec spec;
  spec.how = Sheets{};
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  spec.division.region_size = 16;
  const glm::ivec3 dims{30, 20, 25};
  for (const Camera& camera :
       {Camera{.azimuth = 31, .elevation = 17, .zoom = 0.5, .fov = 60},
        Camera{.azimuth = 120, .elevation = -40, .zoom = 0.6, .fov = 100, .distance = 1.05},
        Camera{.azimuth = 0, .elevation = 0, .zoom = 0.4, .fov = 120, .distance = 0.6}}) {
    spec.shown.camera = camera;
    const FrameGeometry g = make_geometry(spec, make_grid(dims));
    for (int i = 0; i <= 4; ++i)
      for (int j = 0; j <= 4; ++j)
        for (int k = 0; k <= 4; ++k) {
          const glm::dvec3 p = 0.25 * glm::dvec3(i, j, k) * glm::dvec3(dims) - 0.5;
          if (!std::isfinite(g.view.magnification(p))) continue;
          const glm::dvec2 at = glm::floor(g.view.seen_at(p));
          if (at.x < 0 || at.y < 0 || at.x >= g.width || at.y >= g.height) continue;
          const int column = int(at.x) / 16, row = int(at.y) / 16;
          REQUIRE(column >= g.reached.x0);
          REQUIRE(column < g.reached.x1);
          REQUIRE(row >= g.reached.y0);
          REQUIRE(row < g.reached.y1);
        }
    CHECK((g.reached.x1 - g.reached.x0) * (g.reached.y1 - g.reached.y0) < 32 * 32);
  }
}

// Truths with a clip box against those of cropped volumes and closed forms, and the renderer against them.
#include <glm/geometric.hpp>

#include "ringsplat/base/error.hpp"
#include "study/error_budget.hpp"
#include "support/catch.hpp"
#include "truth_support.hpp"
#include "volume/synth.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const std::vector<VoxelBox> boxes{
    {{3, 2, 4}, {14, 13, 17}}, {{0, 5, 6}, {17, 6, 19}}, {{8, 7, 9}, {9, 8, 10}}, {{5, 0, 0}, {12, 15, 10}}};

/// The volume cropped to the box, at its place.
Volume cut(const VoxelBox& box) {
  const glm::ivec3 f = box.first;
  Volume part = make_volume(
      box.end - f, ScalarType::float32,
      [&](int x, int y, int z) { return noisy_lump(x + f.x, y + f.y, z + f.z); }, lump_spacing);
  part.grid.origin = lump_spacing * glm::dvec3(f);
  return part;
}

/// Along z, y or x.
Camera matrix_view(int axis) {
  std::array<double, 12> m{};
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  m[std::size_t(u)] = 2, m[std::size_t(v)] = 0.25, m[std::size_t(axis)] = 0.5, m[3] = 2;
  m[std::size_t(4 + u)] = -0.25, m[std::size_t(4 + v)] = 2, m[std::size_t(4 + axis)] = -0.375, m[7] = 9;
  m[std::size_t(8 + u)] = 0.25, m[std::size_t(8 + axis)] = axis == 1 ? -2 : 2;
  return {.matrix = m};
}

FrameSpec spec_for(const Method& how, const Camera& camera, int size = 48) {
  FrameSpec spec = plain_spec(ramp(20, 240, 0.5), size, camera);
  spec.how = how;
  spec.shown.shading = Shading::phong;
  return spec;
}

double most_opaque(const std::vector<truth::Rgba>& colours) {
  double most = 0;
  for (const auto& colour : colours) most = std::max(most, colour.w);
  return most;
}

const Camera oblique{.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2};

}  // namespace

TEST_CASE("a clipped truth is the cropped volume's") {
  const Volume whole = lump_volume();
  const auto pixels = truth::all_pixels(48, 48);
  for (const VoxelBox& box : boxes)
    for (int axis = 0; axis < 3; ++axis) {
      CAPTURE(axis, box.first.x);
      FrameSpec spec = spec_for(Splats{}, matrix_view(axis));
      auto part = scene_of(cut(box), spec);
      spec.shown.clip = box;
      auto clipped = scene_of(whole, spec);
      CHECK(largest_difference(truth::field_truth(clipped, pixels, 1e-9),
                               truth::field_truth(part, pixels, 1e-9)) < 1e-8);
      for (const Method& how : {Method{Splats{}}, Method{Sheets{}}}) {
        part.frame.how = clipped.frame.how = how;
        const auto method = truth::method_truth(clipped, pixels);
        REQUIRE(most_opaque(method) > 0.05);
        CHECK(largest_difference(method, truth::method_truth(part, pixels)) < 1e-12);
      }
    }
}

TEST_CASE("in perspective, too, a clipped medium is as opaque as its box is long") {
  const Volume even = make_volume(
      lump_dims, ScalarType::uint8, [](int, int, int) { return 200; }, lump_spacing);
  const glm::dvec3 dims(lump_dims);
  const auto pixels = truth::all_pixels(32, 32);
  for (const double fov : {0.0, 40.0, 80.0})
    for (const VoxelBox& box : boxes) {
      FrameSpec spec = spec_for(Sheets{}, {.azimuth = 31, .elevation = 17, .zoom = 1.3, .fov = fov}, 32);
      spec.shown.shading = Shading::none;
      spec.shown.transfer_function = constant_opacity(0.1);
      truth::Scene scene = scene_of(even, spec);
      std::vector<double> expected;
      for (const truth::Pixel pixel : pixels)
        expected.push_back(truth::length_in_box(truth::cube_ray(scene, pixel), glm::dvec3(box.first) / dims,
                                                glm::dvec3(box.end) / dims));
      scene.frame.shown.clip = box;
      const auto field = truth::field_truth(scene, pixels, 1e-10),
                 sheets = truth::method_truth(scene, pixels),
                 formula = truth::analytic_truth(scene, synth_field("constant"), 200, pixels, 1e-10);
      double most = 0;
      for (std::size_t p = 0; p < pixels.size(); ++p) {
        const double opacity = 1 - std::pow(0.9, expected[p]);
        CAPTURE(fov, pixels[p].x, pixels[p].y);
        REQUIRE(std::abs(field[p].w - opacity) < 1e-8);
        REQUIRE(std::abs(sheets[p].w - opacity) < 1e-8);
        REQUIRE(std::abs(formula[p].w - opacity) < 1e-8);
        most = std::max(most, opacity);
      }
      CHECK(most > 0.05);
    }
}

TEST_CASE("clipped pictures of both engines are their methods'") {
  const Volume whole = lump_volume();
  for (const VoxelBox& box : boxes)
    for (const Camera& camera : {oblique, Camera{.azimuth = 100, .elevation = -20},
                                 Camera{.azimuth = 20, .elevation = 70, .zoom = 1.4}}) {
      FrameSpec spec = spec_for(Splats{}, camera, 64);
      spec.shown.clip = box;
      CAPTURE(camera.azimuth, box.first.x);
      REQUIRE(brightest(rendered(whole, spec)) > 0.03F);
      CHECK(numerical_error(whole, spec) < 1e-5);
      spec.how = Sheets{.adaptive = false};
      for (const double fov : {0.0, 40.0}) {
        spec.shown.camera.fov = fov;
        const Image sheets = rendered(whole, spec);
        REQUIRE(brightest(sheets) > 0.03F);
        const auto error = truth::compare(sheets, method_image(whole, spec)).total;
        CHECK(error.rmse < 0.25);
        CHECK(error.largest < 6);
        FrameSpec adaptive = spec;
        adaptive.as<Sheets>().adaptive = true;
        CHECK(truth::compare(rendered(whole, adaptive), sheets).total.rmse < 0.35);
      }
    }
}

TEST_CASE("outside of its bounds a clipped truth is transparent, and the bounds are the clip box's") {
  const Volume whole = lump_volume();
  const auto pixels = truth::all_pixels(48, 48);
  for (const VoxelBox& box : boxes)
    for (const Method& how : {Method{Splats{}}, Method{Sheets{}}}) {
      FrameSpec spec = spec_for(how, oblique);
      const std::size_t all = pixels_of(truth::method_bounds(scene_of(whole, spec)));
      spec.shown.clip = box;
      const auto scene = scene_of(whole, spec);
      const auto method = truth::method_truth(scene, pixels), field = truth::field_truth(scene, pixels, 1e-6);
      const auto of_method = truth::method_bounds(scene), of_field = truth::field_bounds(scene);
      CHECK(pixels_of(of_method) < all);
      CHECK(pixels_of(of_field) <= pixels_of(of_method));
      for (std::size_t p = 0; p < pixels.size(); ++p) {
        if (!of_method.rows[std::size_t(pixels[p].y)].contains(pixels[p].x)) REQUIRE(method[p].w == 0);
        if (!of_field.rows[std::size_t(pixels[p].y)].contains(pixels[p].x)) REQUIRE(field[p].w == 0);
      }
    }
}

TEST_CASE("truths refuse a clip box that is none of the volume's") {
  const Volume whole = lump_volume();
  for (const Method& how : {Method{Splats{}}, Method{Sheets{}}}) {
    auto scene = scene_of(whole, spec_for(how, oblique));
    scene.frame.shown.clip = VoxelBox{{0, 0, 0}, {18, 15, 19}};
    const auto pixels = truth::all_pixels(2, 2);
    CHECK_THROWS_AS(truth::method_truth(scene, pixels), InputError);
    CHECK_THROWS_AS(truth::field_truth(scene, pixels), InputError);
    CHECK_THROWS_AS(truth::analytic_truth(scene, synth_field("ball"), 1, pixels), InputError);
  }
}

#include <glm/geometric.hpp>

#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// A soft body with detail at every scale, of 8 or 16 bits.
Volume body(glm::ivec3 dims, ScalarType type = ScalarType::uint16) {
  const double scale = truth::synth_scale(type);
  return make_volume(dims, type, [&](int x, int y, int z) {
    const glm::dvec3 p = (glm::dvec3(x, y, z) + 0.5) / glm::dvec3(dims);
    const double r = glm::length(p - 0.5);
    return scale *
           std::max(0.0, (1 - 2 * r) * (0.8 + 0.2 * std::sin(40 * p.x) * std::cos(33 * p.y + 20 * p.z)));
  });
}

FrameSpec spec_of(double opacity, int size, const Camera& camera, ScalarType type = ScalarType::uint16) {
  FrameSpec spec =
      plain_spec(ramp(0.05 * truth::synth_scale(type), truth::synth_scale(type), opacity), size, camera);
  spec.shown.shading = Shading::phong;
  return spec;
}

}  // namespace

TEST_CASE("one voxel is its kernel, by hand") {
  // Opacity 0.4 over slices 1/cos apart; kernel 3 / (π T²) (1 − r²)² at the pixel the centre falls on.
  const Volume volume = make_volume({1, 1, 1}, ScalarType::uint8, [](int, int, int) { return 200; });
  FrameSpec spec =
      plain_spec(constant_opacity(0.4), 65, {.azimuth = 0, .elevation = 60, .roll = 0, .zoom = 1});
  const double opacity = 1 - std::pow(0.6, 1 / std::cos(M_PI / 6));
  CHECK(method_at(scene_of(volume, spec), {32, 32}).w ==
        Approx(3 / (M_PI * 1.6 * 1.6) * opacity).epsilon(1e-12));
}

TEST_CASE("the renderer agrees with the method's own truth to float precision") {
  const Volume volume = body({40, 37, 43});
  const Camera cameras[] = {{},
                            {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2},
                            {.azimuth = 200, .elevation = -60, .roll = 100, .zoom = 0.7},
                            {.azimuth = 90, .elevation = 44, .roll = 0, .zoom = 3}};
  for (const auto& camera : cameras)
    for (const Shading shading : {Shading::none, Shading::phong})
      for (const double radius : {1.0, 1.6, 2.5})
        for (const bool correction : {true, false}) {
          FrameSpec spec = spec_of(0.3, 72, camera);
          spec.shown.shading = shading;
          spec.as<Splats>().kernel_radius = radius;
          spec.shown.opacity_correction = correction;
          CAPTURE(camera.azimuth, shading, radius, correction);
          // Float sums of up to 43 slices, and colours of 16 bits: 8e-6 of a colour at most.
          CHECK(numerical_error(volume, spec) < 1e-5);
        }
}

TEST_CASE("after 512 slices the renderer is still within 2e-5 of the truth") {
  const Volume volume = body({24, 512, 24});
  for (const double opacity : {0.005, 0.05, 0.9}) {
    FrameSpec spec = spec_of(opacity, 48, {.azimuth = 3, .elevation = 2, .roll = 0, .zoom = 10});
    INFO("opacity " << opacity);
    CHECK(numerical_error(volume, spec) < 2e-5);
  }
}

TEST_CASE("all scalar types agree with the truth") {
  for (const ScalarType type :
       {ScalarType::int8, ScalarType::uint8, ScalarType::int16, ScalarType::uint16, ScalarType::int32,
        ScalarType::uint32, ScalarType::float32, ScalarType::float64}) {
    INFO(to_string(type));
    CHECK(numerical_error(body({21, 22, 23}, type),
                          spec_of(0.3, 48, {.azimuth = 20, .elevation = 30, .roll = 5, .zoom = 1}, type)) <
          1e-5);
  }
}

TEST_CASE("the 16-bit normals cost less than a quarter of a level") {
  const Volume volume = body({40, 37, 43});
  const FrameSpec spec = spec_of(0.3, 96, {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2});
  const auto error = truth::compare(rendered(volume, spec), method_image(volume, spec, Normals::exact));
  CHECK(error.total.rmse > 1e-3);  // they are there
  CHECK(error.total.rmse < 0.05);
  CHECK(error.total.largest < 0.25);
}

TEST_CASE("a pixel's colour does not depend on which others are asked for") {
  const Volume volume = body({20, 21, 22});
  const auto scene =
      scene_of(volume, spec_of(0.3, 40, {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1}));
  const auto every = truth::all_pixels(40, 40);
  const auto some = random_pixels(40, 40, 100, 3);
  const auto all_colours = truth::method_truth(scene, every), some_colours = truth::method_truth(scene, some);
  for (std::size_t k = 0; k < some.size(); ++k)
    CHECK(some_colours[k] == all_colours[std::size_t(some[k].y * 40 + some[k].x)]);
}

TEST_CASE(
    "the normals' rounding costs a lit head 0.02 to 0.07 levels, and is all that the renderer errs by") {
  const Volume volume = head();
  for (const auto& [name, most] : {std::pair{"mr-soft", 0.04}, {"mr-skin", 0.045}, {"mr-surface", 0.085}}) {
    FrameSpec spec = plain_spec(head_preset(name), 128, {.azimuth = 20, .elevation = 10});
    spec.shown.shading = Shading::phong;
    const Image exact = method_image(volume, spec, Normals::exact);
    const truth::ErrorFigures rounding = truth::compare(method_image(volume, spec), exact).total;
    const truth::ErrorFigures whole = truth::compare(rendered(volume, spec), exact).total;
    INFO(name << ": RMSE " << rounding.rmse << ", largest " << rounding.largest);
    CHECK(rounding.rmse > 0.02);
    CHECK(rounding.rmse < most);
    CHECK(rounding.largest < 2.5);
    CHECK(whole.rmse == Approx(rounding.rmse).epsilon(0.01));
  }
}

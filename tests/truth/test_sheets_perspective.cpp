// Perspective pictures of the sheets engine against their method's truth and against the field.
#include "sampled_errors.hpp"
#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

FrameSpec perspective_spec(const TransferFunction& tf, const Camera& camera, Shading shading = Shading::phong,
                           int size = 128) {
  FrameSpec spec = plain_spec(tf, size, camera);
  spec.shown.shading = shading;
  spec.how = Sheets{};
  return spec;
}

}  // namespace

TEST_CASE("in perspective the head is as near to the field as from afar") {
  const Volume volume = head();
  struct {
    const char* preset;
    Shading shading;
    double field;
  } const cases[] = {{"mr-soft", Shading::phong, 0.65},
                     {"mr-soft", Shading::none, 0.3},
                     {"mr-surface", Shading::phong, 1.2},
                     {"mr-surface", Shading::none, 0.8}};
  const Camera views[] = {{.azimuth = 20, .elevation = 10, .fov = 40},
                          {.azimuth = 70, .elevation = 20, .fov = 40},
                          {.elevation = 65, .fov = 40}};
  for (const auto& [preset, shading, bound] : cases)
    for (const Camera& camera : views) {
      const FrameSpec spec = perspective_spec(head_preset(preset), camera, shading, 160);
      CAPTURE(preset, shading, camera.azimuth);
      const Image picture = rendered(volume, spec);
      CHECK(from_field(volume, spec, 4000).of(picture) < bound);
      CHECK(from_method(volume, spec, 4000).of(picture) < 0.45);
    }
}

TEST_CASE("near eyes, wide and narrow fields of view, pans, tilted lattices and floats are their method's") {
  const Volume volume = head(), tilted = [] {
    Volume v = make_volume({40, 36, 8}, ScalarType::float32,
                           [](int x, int y, int z) { return 100 + 50 * std::sin(0.4 * x + 0.3 * y * z); },
                           {1, 1, 10});
    v.grid.direction[2] = glm::dvec3(0.3, -0.2, std::sqrt(1 - 0.13));
    return v;
  }();
  struct {
    const Volume& volume;
    Camera camera;
  } const cases[] = {
      {volume, {.azimuth = 33, .elevation = 21, .roll = 8, .fov = 90}},
      {volume, {.azimuth = 160, .elevation = -40, .zoom = 0.7, .fov = 60, .distance = 1.05}},
      {volume, {.azimuth = 45, .elevation = 35, .zoom = 3, .fov = 20, .pan = {0.4, -0.3}}},
      {volume, {.azimuth = 10, .elevation = 5, .fov = 0.02}},
      {volume, {.azimuth = 45, .elevation = 35, .zoom = 2, .fov = 150, .distance = 1.3}},
      {volume, {.fov = 40, .eye = glm::dvec3(150, -260, 120), .target = glm::dvec3(20, 0, 30)}},
      {tilted, {.azimuth = 25, .elevation = 50, .fov = 40}},
      {tilted, {.azimuth = 100, .elevation = 5, .fov = 60, .distance = 1.2}}};
  for (const auto& [shown, camera] : cases)
    for (const bool corrected : {true, false}) {
      FrameSpec spec = perspective_spec(head_preset("mr-soft"), camera, Shading::phong, 96);
      spec.shown.opacity_correction = corrected;
      spec.as<Sheets>().adaptive = false;
      CAPTURE(camera.azimuth, camera.fov);
      CHECK(brightest(rendered(shown, spec)) > 0.05F);
      // Between slices ten units apart the table's steps show more.
      CHECK(method_error(shown, spec) < (&shown == &tilted ? 0.8 : 0.4));
    }
}

TEST_CASE("from very far a perspective picture is the orthographic one, undersampled too") {
  const Volume volume = head();
  for (const int factor : {1, 2, 4}) {
    FrameSpec spec = perspective_spec(head_preset("mr-soft"), {.azimuth = 33, .elevation = 21});
    spec.shown.reduction.factor = factor;
    const Image orthographic = rendered(volume, spec);
    spec.shown.camera.fov = 0.02;
    CAPTURE(factor);
    CHECK(truth::compare(rendered(volume, spec), orthographic).total.rmse < 0.1);
  }
}

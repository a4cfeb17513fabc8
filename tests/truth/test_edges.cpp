// Opacity by the gradient's magnitude: the truths against closed forms, and sheets against the truths.
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Camera cameras[] = {{.azimuth = 33, .elevation = 21, .zoom = 1.2},
                          {.azimuth = 100, .elevation = -20, .fov = 40},
                          {.azimuth = 20, .elevation = 70}};

}  // namespace

TEST_CASE("opacity goes by the gradient in values over world lengths, whatever the spacing and the type") {
  // 3 a voxel of half a world length: 6. Rays from the front cross 10 voxels that are 2 long.
  const double through = 0.9;  // of the smallest spacing
  for (const ScalarType type : {ScalarType::uint8, ScalarType::int16, ScalarType::float32})
    for (const Shading shading : {Shading::none, Shading::phong}) {
      const Volume ramped =
          make_volume({20, 10, 12}, type, [](int x, int, int) { return 3 * x; }, {0.5, 2, 1});
      FrameSpec spec = plain_spec(ramp(-2000, -1000, 1 - through), 32, {});
      spec.how = Sheets{};
      spec.shown.shading = shading;
      const auto check_share = [&](double from, double to, double share) {
        spec.shown.edges = EdgeOpacity{from, to};
        const double wanted = 1 - std::pow(through, share * 40);
        const truth::Scene scene = scene_of(ramped, spec);
        CAPTURE(to_string(type), from, to);
        CHECK(field_at(scene, {16, 16}).w == Approx(wanted).margin(1e-8));
        CHECK(method_at(scene, {16, 16}).w == Approx(wanted).margin(1e-8));
        CHECK(rendered(ramped, spec).rgba[4 * (16 * 32 + 16) + 3] == Approx(wanted).margin(2e-3));
      };
      check_share(5, 7, 0.5);
      check_share(0, 6, 1);
      check_share(6.2, 8, 0);
      check_share(3, 15, 0.25);
    }
}

TEST_CASE("sheets whose opacity goes by gradients are their method's, and near the field") {
  const Volume volume = lump_volume();
  for (const Camera& camera : cameras)
    for (const Shading shading : {Shading::none, Shading::phong}) {
      FrameSpec spec = plain_spec(ramp(20, 240, 0.5), 64, camera);
      spec.shown.shading = shading;
      spec.how = Sheets{.adaptive = false};
      const Image all = rendered(volume, spec);
      spec.shown.edges = EdgeOpacity{8, 30};
      const Image image = rendered(volume, spec);
      INFO("azimuth " << camera.azimuth);
      const auto error = truth::compare(image, method_image(volume, spec)).total;
      CHECK(error.rmse < 0.3);
      CHECK(error.largest < 9);
      CHECK(truth::compare(image, all).total.rmse > 2);
      spec.how = Sheets{};
      CHECK(field_error(volume, spec) < 1.5);
    }
}

TEST_CASE("a window of magnitudes that does not ascend and splats are refused") {
  FrameSpec spec = plain_spec(ramp(20, 240, 0.5), 64, {});
  spec.how = Sheets{};
  for (const auto& [from, to] : {std::pair{2.0, 2.0}, {-1.0, 2.0}, {0.0, INFINITY}}) {
    spec.shown.edges = EdgeOpacity{from, to};
    CHECK(says(message_of([&] { check(spec); }), "is no window of magnitudes"));
  }
  spec.shown.edges = EdgeOpacity{1, 2};
  CHECK_NOTHROW(check(spec));
  spec.how = Splats{};
  CHECK(says(message_of([&] { check(spec); }), "splats' opacities do not go by gradients"));
}

#include <fmt/format.h>

#include "support/catch.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

FrameSpec oblique_view() {
  FrameSpec spec{.how = Splats{}};
  spec.shown.camera = {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.1};
  spec.shown.width = spec.shown.height = 96;
  spec.division.region_size = 40;
  spec.shown.opaque_threshold = 0;
  spec.shown.shading = Shading::none;
  spec.shown.transfer_function = ramp(10, 255, 0.15);
  return spec;
}

}  // namespace

TEST_CASE("an undersampled picture shows the same volume at the same place, as opaque as the full one") {
  const auto source = synth_source("gaussians", make_grid({64, 60, 56}));
  FrameSpec spec = oblique_view();
  const auto full = render_loopback(*source, spec, 2, 2);
  REQUIRE(brightest(full.image) > 0.5F);
  for (const double azimuth : {33.0, 123.0}) {
    spec.shown.camera.azimuth = azimuth;
    spec.shown.reduction = {};
    const auto whole = render_loopback(*source, spec, 2, 2);
    for (const int factor : {2, 4}) {
      INFO(fmt::format("azimuth {}, factor {}", azimuth, factor));
      spec.shown.reduction = {factor, false};
      const auto skipped = render_loopback(*source, spec, 2, 2);
      spec.shown.reduction = {factor, true};
      const auto means = render_loopback(*source, spec, 2, 2);
      const auto splats = [](const FrameResult& r) { return double(r.stats.total().visible_voxels); };
      CHECK(splats(skipped) < 1.3 * splats(whole) / (factor * factor * factor));
      // Blobs with a deviation of 4 to 6 voxels: a smooth field's picture changes only by the coarser kernel.
      CHECK(255 * rms_difference(means.image, whole.image) < (factor == 2 ? 3.0 : 10.0));
      CHECK(255 * rms_difference(means.image, whole.image) > 0);
      CHECK(255 * rms_difference(skipped.image, whole.image) < (factor == 2 ? 4.0 : 16.0));
    }
  }
}

TEST_CASE("an even slab is as opaque undersampled as in full") {
  const auto source = synth_source("constant", make_grid({40, 40, 40}));
  FrameSpec spec = oblique_view();
  spec.shown.camera = {.elevation = 90, .zoom = 3};
  spec.shown.transfer_function = constant_opacity(0.02);
  const float full = render_loopback(*source, spec, 1, 1).image.pixel(48, 48)[3];
  for (const bool prefilter : {false, true}) {
    spec.shown.reduction = {4, prefilter};
    // The kernel's own ripple is at most 3 % of the opacity.
    CHECK(render_loopback(*source, spec, 1, 1).image.pixel(48, 48)[3] == Approx(full).epsilon(0.03));
  }
}

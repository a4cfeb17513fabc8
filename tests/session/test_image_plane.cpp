#include <fmt/format.h>

#include "support/catch.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

FrameSpec sheared_view(double azimuth, double elevation = 21) {
  FrameSpec spec = oblique_view(120, 104, 16);
  spec.shown.camera.azimuth = azimuth;
  spec.shown.camera.elevation = elevation;
  spec.as<Splats>().image_plane = ImagePlane::slices;
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  return spec;
}

}  // namespace

TEST_CASE("a picture drawn in the slices' plane has the same bits for any ranks and regions") {
  const auto source = synth_source("ball", make_grid({33, 27, 30}));
  LoopbackOptions shuffled;
  shuffled.reorder = true;
  shuffled.seed = 5;
  for (const double azimuth : {0.0, 33.0, 123.0, 303.0}) {
    for (const int samples : {1, 2, 4}) {
      FrameSpec spec = sheared_view(azimuth, azimuth > 300 ? 70 : 21);
      spec.as<Splats>().plane_samples = samples;
      const Image alone = render_loopback(*source, spec, 1, 1).image;
      REQUIRE(alone.width == spec.shown.width);
      REQUIRE(alone.height == spec.shown.height);
      REQUIRE(brightest(alone) > 0.1F);
      for (const auto& [gps, renderers] : {std::pair{3, 2}, {2, 5}, {8, 4}}) {
        for (const int region : {5, 64}) {
          INFO(fmt::format("azimuth {}, {} samples, {} + {} nodes, regions of {}", azimuth, samples, gps,
                           renderers, region));
          spec.division.region_size = region;
          CHECK(render_loopback(*source, spec, gps, renderers, shuffled).image == alone);
        }
      }
    }
  }
}

TEST_CASE("an even slice is even in the slices' plane, but for the kernels' ripple") {
  // Of radius 2.5: 0.53 % at most, which the warp's cubic may make half as large again.
  const auto source = synth_source("constant", make_grid({41, 43, 1}));
  for (const int samples : {1, 2, 4}) {
    FrameSpec spec = sheared_view(10, 70);
    spec.shown.width = spec.shown.height = 320;
    spec.shown.camera.zoom = 1;
    spec.as<Splats>().plane_samples = samples;
    spec.as<Splats>().kernel_radius = 2.5;
    spec.shown.transfer_function = constant_opacity(0.3);
    spec.shown.opacity_correction = false;
    const Image image = render_loopback(*source, spec, 2, 3).image;
    float least = 1, most = 0;
    for (int y = 110; y < 210; ++y)
      for (int x = 110; x < 210; ++x) {
        least = std::min(least, image.pixel(x, y)[3]);
        most = std::max(most, image.pixel(x, y)[3]);
      }
    INFO(samples << " samples");
    CHECK(least == Approx(0.3).epsilon(0.008));
    CHECK(most == Approx(0.3).epsilon(0.008));
  }
}

TEST_CASE("more samples a voxel bring the picture to the one drawn on the screen") {
  const auto source = synth_source("ball", make_grid({33, 27, 30}));
  for (const double azimuth : {0.0, 33.0, 123.0}) {
    FrameSpec spec = sheared_view(azimuth);
    spec.shown.camera.zoom = 1;
    spec.shown.width = spec.shown.height = 400;
    spec.shown.opaque_threshold = 0;
    spec.as<Splats>().image_plane = ImagePlane::screen;
    const Image screen = render_loopback(*source, spec, 1, 1).image;
    spec.as<Splats>().image_plane = ImagePlane::slices;
    double before = 1;
    for (const int samples : {1, 2, 4}) {
      spec.as<Splats>().plane_samples = samples;
      const double error = rms_difference(render_loopback(*source, spec, 1, 1).image, screen);
      INFO(fmt::format("azimuth {}, {} samples: {}", azimuth, samples, error));
      CHECK(error < (samples == 1 ? 0.01 : before / 1.6));
      before = error;
    }
  }
}

TEST_CASE("the slices' plane draws fewer pixels and sends as many voxels") {
  const auto source = synth_source("ball", make_grid({33, 27, 30}));
  FrameSpec spec = sheared_view(33);
  spec.shown.width = spec.shown.height = 400;
  const NodeStats slices = render_loopback(*source, spec, 1, 1).stats.total();
  spec.as<Splats>().image_plane = ImagePlane::screen;
  const NodeStats screen = render_loopback(*source, spec, 1, 1).stats.total();
  CHECK(slices.visible_voxels == screen.visible_voxels);
  CHECK(10 * slices.tile_bytes < screen.tile_bytes);
}

TEST_CASE("undersampled, mirrored, tiny and empty views are drawn in the slices' plane as well") {
  const auto source = synth_source("ball", make_grid({33, 27, 30}));
  FrameSpec spec = sheared_view(33);
  const auto error = [&] {
    spec.as<Splats>().image_plane = ImagePlane::screen;
    const Image screen = render_loopback(*source, spec, 2, 2).image;
    spec.as<Splats>().image_plane = ImagePlane::slices;
    return rms_difference(render_loopback(*source, spec, 2, 2).image, screen);
  };
  spec.shown.reduction = {2, true};
  CHECK(error() < 0.02);
  spec.shown.reduction = {};
  spec.shown.camera.zoom = 0.1;
  CHECK(error() < 0.02);
  spec.shown.camera.zoom = 20;
  CHECK(error() < 0.02);
  spec.shown.camera.matrix = {{-2, 0.3, 0.1, 130, 0.2, 0.1, -2, 100, 0.1, 2, 0.1, 0}};
  CHECK(error() < 0.02);
  spec.shown.camera.matrix = {{1, 0, 0, 5000, 0, 0, -1, 5000, 0, 1, 0, 0}};
  CHECK(error() == 0);
}

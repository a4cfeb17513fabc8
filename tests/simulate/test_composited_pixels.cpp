// What a run that only counts says a Renderer composites, against what one composites.
#include "base/thread_team.hpp"
#include "classify/empty_space.hpp"
#include "net/message.hpp"
#include "simulate/meter.hpp"
#include "splat_engine/splat_engine.hpp"
#include "support/catch.hpp"
#include "support/dealt.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int renderers = 4;

FrameSpec view_of(Camera camera) {
  FrameSpec spec = oblique_view(400, 400, 0);
  spec.shown.camera = camera;
  spec.shown.transfer_function = ramp(110, 255, 0.3);
  spec.shown.shading = Shading::none;
  spec.shown.opaque_threshold = 0;
  spec.division.region_size = 64;
  return spec;
}

struct Pixels {
  double counted = 0, composited = 0;
};

Pixels pixels_of(const FrameSpec& spec, const Grid& grid, double voxel_weight, int threads_of_gp = 1) {
  const auto frame = make_weighed_frame(spec, grid, 1, renderers, voxel_weight);
  const auto source = synth_source("ball", grid);
  const auto stores = dealt(*source, 1);
  EmptySpace space;
  ThreadTeam threads(threads_of_gp), alone;
  const auto encoder = make_splat_encoder(frame, renderers, stores.at(0), space, threads, false);
  const auto meter = make_splat_meter(frame, voxel_weight);
  std::vector<std::unique_ptr<FramePainter<SplatFrame>>> painters;
  for (int r = 0; r < renderers; ++r) {
    painters.push_back(make_splat_painter(r, alone));
    painters.back()->begin_frame(frame);
  }
  Pixels pixels;
  for (const int step : {20, 50, 60}) {
    encoder->begin(step);
    while (!encoder->work()) {
    }
    const EncodedStep encoded = encoder->finish();
    for (const PaintWork& work : meter(step, encoded.parts)) pixels.counted += double(work.samples);
    for (int r = 0; r < renderers; ++r) {
      const EncodedPart& part = encoded.parts[std::size_t(r)];
      if (part.payload.empty()) continue;
      Painter& painter = *painters[std::size_t(r)];
      painter.begin({step, part.passes, std::span(part.payload).subspan(sizeof(Header))});
      while (!painter.work()) {
      }
    }
  }
  for (const auto& painter : painters) pixels.composited += double(painter->counts().samples);
  return pixels;
}

}  // namespace

TEST_CASE("the pixels that a GP counts are those that Renderers composite") {
  const Grid grid = make_grid({96, 96, 96});
  const Camera above{.azimuth = 0, .elevation = 90}, turned{.azimuth = 35, .elevation = 60};
  for (const Camera& camera : {above, turned}) {
    const Pixels pixels = pixels_of(view_of(camera), grid, 1);
    CHECK(pixels.composited > 1000);
    // Kernels are round: their windows' outermost rows and columns may hold none of their pixels.
    CHECK(pixels.composited <= pixels.counted);
    CHECK(pixels.composited == Approx(pixels.counted).epsilon(0.15));
    CHECK(pixels_of(view_of(camera), grid, 1, 3).counted == pixels.counted);
  }
}

TEST_CASE("voxels that stand for others count as many pixels as these do") {
  const FrameSpec spec = view_of({.azimuth = 0, .elevation = 90, .zoom = 1.37});
  const double real = pixels_of(spec, make_grid({384, 384, 96}), 1).counted,
               weighed = pixels_of(spec, make_grid({96, 96, 96}, ScalarType::uint8, {4, 4, 1}), 16).counted;
  CHECK(weighed == Approx(real).epsilon(0.05));
}

#include "base/thread_team.hpp"
#include "classify/empty_space.hpp"
#include "simulate/meter.hpp"
#include "splat_engine/splat_engine.hpp"
#include "support/catch.hpp"
#include "support/dealt.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Splats of a volume, in regions of 32 pixels, for each visible voxel.
double splats_of_a_voxel(const Grid& grid, double voxel_weight) {
  constexpr int renderers = 6;
  FrameSpec spec = oblique_view(400, 400, 0);
  spec.shown.camera = {.azimuth = 0, .elevation = 90, .zoom = 1.37};
  spec.shown.transfer_function = ramp(110, 255, 0.3);
  spec.shown.shading = Shading::none;
  spec.division.region_size = 32;
  spec.how = Splats{};
  const auto frame = make_weighed_frame(spec, grid, 1, renderers, voxel_weight);
  const auto source = synth_source("ball", grid);
  const auto stores = dealt(*source, 1);
  EmptySpace space;
  ThreadTeam threads(1);
  const auto encoder = make_splat_encoder(frame, renderers, stores.at(0), space, threads, false);
  double splats = 0, visible = 0;
  for (const int step : {20, 50, 90, 120}) {
    encoder->begin(step);
    while (!encoder->work()) {
    }
    const EncodedStep encoded = encoder->finish();
    visible += double(encoded.counts.visible);
    for (const EncodedPart& part : encoded.parts) splats += double(part.items);
  }
  return splats / visible;
}

}  // namespace

TEST_CASE("voxels that stand for others make as many splats as these do") {
  const double real = splats_of_a_voxel(make_grid({384, 384, 128}), 1),
               weighed = splats_of_a_voxel(make_grid({96, 96, 128}, ScalarType::uint8, {4, 4, 1}), 16);
  CHECK(real > 1.1);
  // Few voxels lie near a border, so that it is a matter of places how many; kernels of their own size would
  // make four times as many.
  CHECK(weighed - 1 == Approx(real - 1).epsilon(0.4));
}

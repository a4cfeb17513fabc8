#include <fmt/format.h>

#include "support/catch.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

FrameSpec solid_view() {
  FrameSpec spec = oblique_view(120, 104, 32);
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  return spec;
}

}  // namespace

TEST_CASE(
    "opaque pixels: GPs leave out what they hide, and the bits do not depend on when they learn of it") {
  const auto source = synth_source("ball", make_grid({65, 57, 60}));
  FrameSpec spec = solid_view();
  spec.shown.transfer_function = ramp(1, 20, 1.0);
  const auto alone = render_loopback(*source, spec, 1, 1);
  spec.shown.opaque_threshold = 0;
  const auto whole = render_loopback(*source, spec, 1, 1);
  CHECK(whole.stats.total().splats_hidden == 0);
  CHECK(alone.stats.total().splats_sent < whole.stats.total().splats_sent);
  const double error = largest_difference(alone.image, whole.image);
  CHECK(error > 0);
  CHECK(error <= 1.0 / 512);

  spec.shown.opaque_threshold = 1.0 / 512;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const LoopbackOptions loopback{.seed = seed, .reorder = true, .max_delay = int(seed % 7)};
    const ProtocolOptions protocol{
        .slots = 1 + int(seed % 3), .look_ahead = 1 + int(seed / 3) % 3, .send_ahead = int(seed / 2 % 4)};
    spec.division.region_size = std::array{32, 7, 100, 4096}[seed % 4];
    INFO("seed " << seed);
    REQUIRE(render_loopback(*source, spec, 1 + int(seed % 6), 1 + int(seed % 4), loopback,
                            Placement::dedicated, protocol)
                .image == alone.image);
  }
}

TEST_CASE("a volume with nothing to see sends no payload and gives the background") {
  const auto source = synth_source("ball", make_grid({33, 27, 30}));
  FrameSpec spec = solid_view();
  spec.shown.transfer_function = constant_opacity(0.5, 400);
  const auto result = render_loopback(*source, spec, 3, 2);
  const NodeStats total = result.stats.total();
  CHECK(total.payloads_sent == 0);
  CHECK(total.tiles == 0);
  CHECK(total.visible_voxels == 0);
  CHECK(*std::max_element(result.image.rgba.begin(), result.image.rgba.end()) == 0.0F);
}

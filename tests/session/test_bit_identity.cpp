#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "support/catch.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

TEST_CASE("the image has the same bits for any number of GPs and Renderers") {
  const auto source = synth_source("jack", make_grid({33, 27, 30}));
  FrameSpec spec = oblique_view(96, 80, 24);
  for (const double azimuth : {33.0, 123.0, 213.0, 303.0}) {
    spec.shown.camera.azimuth = azimuth;
    const Image alone = render_loopback(*source, spec, 1, 1).image;
    REQUIRE(brightest(alone) > 0.1F);
    for (const int gps : {1, 2, 3, 5, 8, 40})
      for (const int renderers : {1, 2, 3, 4, 20}) {
        INFO(fmt::format("azimuth {}, {} GPs, {} Renderers", azimuth, gps, renderers));
        REQUIRE(render_loopback(*source, spec, gps, renderers).image == alone);
      }
  }
}

TEST_CASE("Renderers without a region get no token, and whoever draws, the bits are the same") {
  const auto source = synth_source("jack", make_grid({23, 27, 20}));
  FrameSpec spec = oblique_view(96, 80, 40);
  spec.shown.camera.zoom = 3;  // every region sees something
  const Image alone = render_loopback(*source, spec, 1, 1).image;
  for (const Placement placement : {Placement::dedicated, Placement::colocated}) {
    for (const auto& [renderers, dealt_to, drawing] :
         {std::array{4, 0, 4}, {4, 2, 2}, {5, 3, 3}, {4, 9, 4}, {8, 0, 6}}) {
      INFO(fmt::format("{} Renderers, regions dealt to {}", renderers, dealt_to));
      spec.division.dealt_to = dealt_to;
      const FrameResult result = render_loopback(*source, spec, 3, renderers, {}, placement);
      CHECK(result.image == alone);
      CHECK(result.stats.total().tokens_issued == std::uint64_t(drawing));
      const auto draws = [](const NodeStats& stats) { return stats.payloads_drawn > 0; };
      CHECK(std::count_if(result.stats.renderers.begin(), result.stats.renderers.end(), draws) == drawing);
    }
  }
}

TEST_CASE("the image has the same bits whatever the order and delay of messages") {
  const auto source = synth_source("jack", make_grid({17, 15, 16}));
  FrameSpec spec = oblique_view(96, 80, 24);
  spec.shown.width = spec.shown.height = 48;
  spec.division.region_size = 16;
  const Image alone = render_loopback(*source, spec, 1, 1).image;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const LoopbackOptions loopback{.seed = seed, .reorder = true, .max_delay = int(seed % 7)};
    const int gps = std::array{1, 2, 3, 5, 8}[seed % 5], renderers = 1 + int(seed / 5) % 4;
    const ProtocolOptions protocol{
        .slots = 1 + int(seed % 3), .look_ahead = 1 + int(seed / 3) % 3, .send_ahead = int(seed / 2 % 4)};
    const auto placement = seed % 2 == 0 ? Placement::dedicated : Placement::colocated;
    INFO(fmt::format("seed {}, {} GPs, {} Renderers", seed, gps, renderers));
    REQUIRE(render_loopback(*source, spec, gps, renderers, loopback, placement, protocol).image == alone);
  }
}

TEST_CASE("several frames are in flight and each has the bits it has alone") {
  const auto source = synth_source("jack", make_grid({17, 15, 16}));
  std::vector<FrameSpec> specs;
  std::vector<Image> alone;
  for (int k = 0; k < 7; ++k) {
    specs.push_back(oblique_view(96, 80, 24));
    specs.back().shown.camera.azimuth = 52.0 * k;
    specs.back().shown.width = specs.back().shown.height = 40 + 8 * (k % 2);
    alone.push_back(render_loopback(*source, specs.back(), 1, 1).image);
  }
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    std::size_t done = 0;
    const auto check_frame = [&](FrameResult&& r) {
      REQUIRE(r.spec.frame == std::int64_t(done));
      REQUIRE(r.image == alone[done]);
      ++done;
    };
    render_directed(*source, {}, {3, 2}, director_of(specs, check_frame),
                    {.seed = seed, .reorder = true, .max_delay = 4}, {.frames_in_flight = 1 + int(seed % 4)});
    REQUIRE(done == specs.size());
  }
}

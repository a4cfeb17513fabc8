// Runs that only count, against runs that draw.
#include "simulate/simulation.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

TEST_CASE("a run that only counts sends as much as one that draws, by both engines and in bundles") {
  const auto source = synth_source("jack", make_grid({33, 29, 24}));
  EngineOptions counting;
  simulate({.count_only = true}, counting);
  Layout bundles{4, 3}, together{3, 3, Placement::colocated};
  bundles.bundle = 5;
  for (const Method& how : {Method(Splats{}), Method(Sheets{})})
    for (const Layout& layout : {Layout{4, 3}, bundles, together, mesh_layout(2, 2, 2)}) {
      FrameSpec spec = oblique_view(96, 80, 0);
      spec.how = how;
      spec.shown.opaque_threshold = 0;  // what is hidden depends on when news come
      const bool sheets = std::holds_alternative<Sheets>(how);
      INFO(layout.gps << " GPs, bundles of " << layout.bundle << (sheets ? ", sheets" : ", splats"));
      const NodeStats drawn = render_loopback(*source, spec, layout).stats.total(),
                      counted = render_loopback(*source, spec, layout, {}, {}, counting).stats.total();
      CHECK(counted.splats_sent == drawn.splats_sent);
      CHECK(counted.splats_drawn == drawn.splats_drawn + drawn.splats_clipped);
      CHECK(counted.payloads_sent == drawn.payloads_sent);
      CHECK(counted.payload_bytes_received == drawn.payload_bytes_received);
      CHECK(counted.passes == drawn.passes);
      CHECK(counted.visible_voxels == drawn.visible_voxels);
      // Splats' windows are counted whole.
      CHECK(counted.samples >= drawn.samples);
      if (sheets) CHECK(counted.samples == drawn.samples);
    }
}

TEST_CASE("a run that only counts sends what Renderers keep once, and counts the rest as one that draws") {
  const Grid grid = make_grid({48, 48, 48});
  const auto frames_of = [&](bool count) {
    SoloCollectives solo;
    const Wiring wiring{solo, nullptr, {}};
    OpenedVolume volume{grid, true, synth_source("jack", grid)};
    std::vector<FrameSpec> turning;
    for (const double azimuth : {20, 26}) {
      turning.push_back(oblique_view(64, 56, 0));
      turning.back().shown.camera = {.azimuth = azimuth, .elevation = 21};
      turning.back().shown.opaque_threshold = 0;
      turning.back().how = Sheets{};
    }
    std::vector<NodeStats> totals;
    EngineOptions engine;
    engine.keep = 64;
    if (count) simulate({.count_only = true}, engine);
    render_frames(load_scene(volume, needed_to_render(turning.front(), grid), {3, 2}, wiring), {3, 2}, {},
                  director_of(turning, [&](FrameResult&& r) { totals.push_back(r.stats.total()); }), wiring,
                  engine);
    return totals;
  };
  const auto drawn = frames_of(false), counted = frames_of(true);
  REQUIRE(counted.size() == 2);
  for (const int frame : {0, 1}) {
    CHECK(counted[frame].payload_bytes_received == drawn[frame].payload_bytes_received);
    CHECK(counted[frame].samples == drawn[frame].samples);
  }
  CHECK(counted[0].splats_sent == drawn[0].splats_sent);
  CHECK(10 * counted[1].splats_sent < drawn[1].splats_sent);
}

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
  Splats words;
  words.payload = PayloadForm::words;
  Layout bundles{4, 3}, together{3, 3, Placement::colocated};
  bundles.bundle = 5;
  for (const Method& how : {Method(Splats{}), Method(words), Method(Sheets{})})
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

#include <algorithm>
#include <cmath>
#include <set>

#include "forecast/forecast.hpp"
#include "program/layouts.hpp"
#include "support/catch.hpp"
#include "volume/synth.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

/// Messages cost nothing, work of GPs and Renderers about as much.
Machine machine(int hosts, int cores) {
  Machine m;
  m.gp = {.visible_voxel = 1e-6, .frame = 1e-3};
  m.renderer = {.splat = 1e-6, .slice = 1e-5};
  m.sheets = {.look = 1e-7, .copy = 1e-5, .place = 1e-5, .sample = 1e-7};
  m.poll_interval = 1e-4;
  m.platform = {.bandwidth = 1e15, .cores = cores, .hosts = hosts};
  return m;
}

Forecast forecast_of(const Method& how, const Machine& m, int ranks) {
  Grid grid;
  grid.dims = glm::ivec3(40, 44, 48);
  grid.type = ScalarType::uint8;
  const auto ball = synth_source("ball", grid);
  FrameSpec frame;
  frame.how = how;
  frame.shown.width = frame.shown.height = 128;
  return Forecast(*ball, frame, TransferFunctionChoice("grey"), {frame.shown.camera}, m, 1, ranks, {});
}

const Layout four{.gps = 4, .renderers = 4, .placement = Placement::colocated};

}  // namespace

TEST_CASE("every way to give ranks their roles is there once and uses them all") {
  for (int ranks = 1; ranks <= 64; ++ranks) {
    const auto layouts = possible_layouts(ranks, true);
    std::set<std::string> names;
    for (const Layout& layout : layouts) {
      CHECK_NOTHROW(check(layout));
      CHECK(layout.ranks() == ranks);
      CHECK(names.insert(describe(layout)).second);
    }
    const auto rings = possible_layouts(ranks, false);
    const auto dedicated = std::count_if(rings.begin(), rings.end(),
                                         [](const Layout& l) { return l.placement == Placement::dedicated; });
    CHECK(dedicated == ranks - 1);
    CHECK(std::find(rings.begin(), rings.end(),
                    Layout{.gps = ranks, .renderers = ranks, .placement = Placement::colocated}) !=
          rings.end());
    CHECK(std::all_of(rings.begin(), rings.end(),
                      [](const Layout& l) { return l.topology == Topology::ring; }));
  }
  const auto six = possible_layouts(6, true), twenty_four = possible_layouts(24, true);
  const auto has = [](const std::vector<Layout>& all, const Layout& layout) {
    return std::find(all.begin(), all.end(), layout) != all.end();
  };
  CHECK(has(six, mesh_layout(2, 2, 2)));
  CHECK(has(twenty_four, mesh_layout(4, 4, 8)));
  CHECK_FALSE(has(twenty_four, mesh_layout(4, 4, 4)));
}

TEST_CASE("of more ranks than cores some may be idle") {
  const auto idle = [](const Layout& layout) { return layout.idle > 0; };
  for (const int ranks : {1, 2, 3, 16}) {
    for (const int cores : {1, 2, 3}) {
      auto layouts = possible_layouts(ranks, true, cores);
      INFO(ranks << " ranks, " << cores << " cores");
      for (const Layout& layout : layouts) {
        CHECK_NOTHROW(check(layout));
        CHECK(layout.ranks() == ranks);
        if (idle(layout)) CHECK(layout.working_ranks() == cores);
      }
      CHECK(std::any_of(layouts.begin(), layouts.end(), idle) == (ranks > cores));
      std::erase_if(layouts, idle);
      CHECK(layouts == possible_layouts(ranks, true));
    }
  }
  CHECK(ranks_with_own_cores(machine(1, 2), 4) == 2);
  CHECK(ranks_with_own_cores(machine(1, 4), 4) == 0);
  CHECK(ranks_with_own_cores(machine(0, 2), 4) == 0);  // as many hosts as needed
  CHECK(ranks_with_own_cores(machine(2, 1), 4) == 0);  // the last ranks are all of a host's
}

TEST_CASE("a frame takes no less than its work takes a host's cores") {
  for (const Method& how : {Method(Splats{}), Method(Sheets{})}) {
    const Prediction own = forecast_of(how, machine(1, 4), 4).predict(four),
                     shared = forecast_of(how, machine(1, 2), 4).predict(four);
    CHECK(own.limit != std::string("the cores"));
    CHECK(shared.limit == std::string("the cores"));
    CHECK(shared.seconds >= shared.shared);
    CHECK(shared.shared == Approx(2 * own.shared));
    CHECK(shared.gp == own.gp);
    CHECK(shared.renderer == own.renderer);
    CHECK(shared.seconds > 1.4 * own.seconds);
  }
}

TEST_CASE("ranks beyond the cores are left idle when they only cost") {
  Machine m = machine(1, 2);
  m.message.wake = 1e-3;
  for (const Method& how : {Method(Splats{}), Method(Sheets{})}) {
    Forecast forecast = forecast_of(how, m, 16);
    const auto all = forecast.predict_all(possible_layouts(16, false, ranks_with_own_cores(m, 16)));
    CHECK(all.front().layout.idle == 14);
    CHECK(std::is_sorted(all.begin(), all.end(),
                         [](const Prediction& a, const Prediction& b) { return a.seconds < b.seconds; }));
  }
}

TEST_CASE("work on a host counts for that host's cores") {
  const Layout layout{.gps = 3, .renderers = 1};
  const std::vector<double> seconds{1, 2, 3, 4};
  CHECK(Hosts(machine(1, 2), layout).shared_seconds(seconds) == 5);
  CHECK(Hosts(machine(2, 2), layout).shared_seconds(seconds) == 3.5);
  CHECK(Hosts(machine(0, 1), layout).shared_seconds(seconds) == 4);
  CHECK(Hosts(machine(1, 2), layout).share_cores());
  CHECK_FALSE(Hosts(machine(2, 2), layout).share_cores());
  CHECK_FALSE(Hosts(machine(0, 1), layout).share_cores());
  // Two of four ranks work.
  CHECK_FALSE(Hosts(machine(1, 2), {.gps = 1, .renderers = 1, .idle = 2}).share_cores());
}

TEST_CASE("what items are called follows from the method") {
  const auto said = [](const Method& how) { return describe(forecast_of(how, machine(0, 1), 2).work()); };
  CHECK_THAT(said(Splats{}), Catch::Matchers::Contains(" splats of "));
  CHECK_THAT(said(Sheets{}), Catch::Matchers::Contains(" blocks of "));
}

TEST_CASE("in a mesh messages go further") {
  // Payload and accept: a column's and a row's distance to the Renderer, each 1/2 in the mean, and the last
  // link. The token: to the right, and every other time back to the next row's left end.
  const MeanHops mesh = mean_hops(mesh_layout(2, 2, 2)),
                 direct = mean_hops(mesh_layout(2, 2, 2, Routing::direct));
  CHECK(mesh.payload == 2);
  CHECK(mesh.accept == 2);
  CHECK(mesh.token == 1.5);
  CHECK(direct.payload + direct.accept + direct.token == 3);
}

TEST_CASE("one rank is no exception") {
  Forecast forecast = forecast_of(Splats{}, machine(1, 2), 1);
  const auto all = forecast.predict_all(possible_layouts(1, true));
  REQUIRE(all.size() == 1);
  CHECK(all.front().layout.placement == Placement::colocated);
  CHECK(all.front().seconds > 0);
}

TEST_CASE("long runs are foreseen by three views") {
  std::vector<Camera> cameras(24);
  for (std::size_t k = 0; k < cameras.size(); ++k) cameras[k].azimuth = 15.0 * double(k);
  const auto views = some_views(cameras);
  REQUIRE(views.size() == 3);
  CHECK(views[0].azimuth == 0);
  CHECK(views[1].azimuth == 120);
  CHECK(views[2].azimuth == 240);
  cameras.resize(5);
  CHECK(some_views(cameras).size() == 1);
}

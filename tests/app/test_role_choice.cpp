#include "forecast/role_choice.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include "forecast/probe.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

constexpr double ms = 1e-3;

/// A core for each rank, and messages that cost nothing.
constexpr RankCosts free_messages{.cores = 1 << 20, .hop = 0, .message_software = 0};

FrameCosts costs(double gp, double renderer, int slices = 1 << 16, int regions = 1 << 12) {
  FrameCosts c;
  c.slices = slices;
  c.gp = gp;
  c.region.assign(std::size_t(regions), renderer / regions);
  return c;
}

Layout best(const FrameCosts& c, const RankCosts& ranks, int count, bool meshes = false) {
  return predict_all(c, ranks, possible_layouts(count, meshes)).front().layout;
}

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
    CHECK(rings.size() == std::size_t(ranks));
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
      CHECK(std::count_if(layouts.begin(), layouts.end(), idle) == (ranks > cores ? cores : 0));
      std::erase_if(layouts, idle);
      CHECK(layouts == possible_layouts(ranks, true));
    }
  }
  // The work is the same, but sixteen ranks share cores and pass more tokens.
  const FrameCosts c = costs(60 * ms, 40 * ms, 100, 64);
  const auto all = predict_all(c, usual_rank_costs(16, 2), possible_layouts(16, false, 2));
  CHECK(describe(all.front().layout) == "2 colocated ranks, 14 idle");
  CHECK(all.front().seconds < all.back().seconds / 1.4);
  RankCosts shared{.cores = 2, .hop = 0, .message_software = 0, .sharing = 1.5};
  const Layout sixteen{.gps = 16, .renderers = 16, .placement = Placement::colocated};
  CHECK(predict(c, shared, sixteen).seconds == Approx(1.5 * 50 * ms));
  CHECK(predict(c, shared, all.front().layout).seconds == Approx(50 * ms));
}

TEST_CASE("sheets' roles are colocated, on as many ranks as there are cores") {
  CHECK(colocated_ring(possible_layouts(5, true)) ==
        Layout{.gps = 5, .renderers = 5, .placement = Placement::colocated});
  const auto sharing = colocated_ring(possible_layouts(16, false, 2));
  REQUIRE(sharing.has_value());
  CHECK(sharing->working_ranks() == 2);
  CHECK(sharing->idle == 14);
  CHECK(sharing->placement == Placement::colocated);
  CHECK_FALSE(colocated_ring({{.gps = 3, .renderers = 2}, {.gps = 2, .renderers = 3}}).has_value());
}

TEST_CASE("the best split shares the work as the two sides' costs ask for") {
  // Without rounding G : R = gp : renderer. Colocated ranks share the work evenly, which can only be better.
  for (const int ranks : {2, 3, 5, 7, 8, 12, 13, 16, 23, 31, 32, 47, 61, 64}) {
    for (const double part : {0.05, 0.25, 0.5, 0.8}) {
      const FrameCosts c = costs(100 * ms * (1 - part), 100 * ms * part);
      auto dedicated = possible_layouts(ranks, false);
      std::erase_if(dedicated, [](const Layout& l) { return l.placement == Placement::colocated; });
      const auto all = predict_all(c, free_messages, dedicated);
      const Prediction& first = all.front();
      for (const Prediction& p : all) CHECK(p.seconds >= first.seconds);
      // Moving one rank to the limiting side is no better.
      const double ideal = part * ranks;
      INFO(ranks << " ranks, Renderers' part " << part << ": " << describe(first.layout));
      CHECK(first.layout.renderers >= std::max(1, int(ideal)));
      CHECK(first.layout.renderers <= std::max(1, std::min(ranks - 1, int(ideal) + 1)));
      const Prediction together =
          predict(c, free_messages, {.gps = ranks, .renderers = ranks, .placement = Placement::colocated});
      CHECK(together.seconds == Approx(100 * ms / ranks).epsilon(0.05));
      CHECK(together.seconds <= first.seconds * 1.05);
    }
  }
}

TEST_CASE("a frame is as long as its longest side, the cores and the tokens") {
  FrameCosts c = costs(60 * ms, 40 * ms, 100, 4);
  SECTION("the side that has most to do") {
    const Prediction p = predict(c, free_messages, {.gps = 4, .renderers = 1});
    CHECK(p.gp == Approx(15 * ms));
    CHECK(p.renderer == Approx(40 * ms));
    CHECK(p.seconds == Approx(40 * ms));
    CHECK(p.limit == Limit::renderers);
    CHECK(predict(c, free_messages, {.gps = 1, .renderers = 2}).limit == Limit::gps);
  }
  SECTION("slices and regions are whole") {
    CHECK(predict(c, free_messages, {.gps = 99, .renderers = 4}).gp == Approx(1.2 * ms));
    CHECK(predict(c, free_messages, {.gps = 1, .renderers = 3}).renderer == Approx(20 * ms));
    CHECK(predict(c, free_messages, {.gps = 1, .renderers = 9}).renderer == Approx(10 * ms));
  }
  SECTION("regions need not be alike") {
    c.region = {30 * ms, 4 * ms, 1 * ms, 5 * ms};
    CHECK(predict(c, free_messages, {.gps = 1, .renderers = 2}).renderer == Approx(31 * ms));
    CHECK(predict(c, free_messages, {.gps = 1, .renderers = 3}).renderer == Approx(35 * ms));
  }
  SECTION("more ranks than cores do not compute faster, and each GP has its setup") {
    c.frame = 1 * ms;
    const RankCosts two{.cores = 2, .hop = 0, .message_software = 0};
    const Prediction p = predict(c, two, {.gps = 12, .renderers = 4});
    CHECK(p.seconds == Approx((60 + 12 + 40) / 2.0 * ms));
    CHECK(p.limit == Limit::cores);
    CHECK(best(c, two, 16) != best(c, free_messages, 16));
  }
  SECTION("a token needs three messages a slice") {
    const RankCosts slow{.cores = 64, .hop = 0.1 * ms, .message_software = 0};
    CHECK(predict(c, slow, {.gps = 2, .renderers = 2}).tokens == Approx(100 * 3 * 0.1 * ms));
    const RankCosts busy{.cores = 1, .hop = 0, .message_software = 0.1 * ms};
    CHECK(predict(c, busy, {.gps = 2, .renderers = 2}).tokens == Approx(2 * 100 * 3 * 0.1 * ms));
    CHECK(predict(c, slow, {.gps = 1, .renderers = 1, .placement = Placement::colocated}).tokens == 0);
  }
  SECTION("with bundles it needs them for each bundle, whose slices one GP has") {
    const RankCosts slow{.cores = 64, .hop = 0.1 * ms, .message_software = 0};
    const Prediction p = predict(c, slow, {.gps = 3, .renderers = 2, .bundle = 10});
    CHECK(p.tokens == Approx(10 * 3 * 0.1 * ms));
    CHECK(p.gp == Approx(60 * 0.4 * ms));  // four of ten bundles
    CHECK(predict(c, slow, {.gps = 3, .renderers = 2, .bundle = 1000}).gp == Approx(60 * ms));
    CHECK(describe(p.layout) == "3 GPs + 2 Renderers, bundles of 10");
  }
  SECTION("in a mesh messages go further") {
    const RankCosts slow{.cores = 64, .hop = 0.1 * ms, .message_software = 0};
    const double ring = predict(c, slow, {.gps = 4, .renderers = 2}).tokens,
                 mesh = predict(c, slow, mesh_layout(2, 2, 2)).tokens,
                 direct = predict(c, slow, mesh_layout(2, 2, 2, Routing::direct)).tokens;
    // Payload and accept: a column's and a row's distance to the Renderer, each 1/2 in the mean, and the last
    // link. The token: to the right, and every other time back to the next row's left end.
    CHECK(mesh == Approx(100 * 0.1 * ms * (2 * 2.0 + 1.5)));
    CHECK(direct == Approx(ring));
  }
}

TEST_CASE("nothing visible and one rank are no exceptions") {
  const FrameCosts nothing = costs(0, 0, 1, 1);
  for (int ranks = 1; ranks <= 64; ++ranks) {
    const auto all = predict_all(nothing, usual_rank_costs(ranks, 2), possible_layouts(ranks, true));
    for (const Prediction& p : all) {
      CHECK(std::isfinite(p.seconds));
      CHECK(p.seconds >= 0);
    }
  }
  CHECK(best(nothing, free_messages, 1).placement == Placement::colocated);
  CHECK_THAT(describe(nothing), Catch::Matchers::Contains("0 visible voxels of 0.0 ns"));
  CHECK(usual_rank_costs(16, 2).hop == Approx(43.2e-6));
  CHECK(usual_rank_costs(2, 2).hop == Approx(2.5e-6));
}

TEST_CASE("long runs are measured by three views") {
  std::vector<Camera> cameras(24);
  for (std::size_t k = 0; k < cameras.size(); ++k) cameras[k].azimuth = 15.0 * double(k);
  const auto views = probe_views(cameras);
  REQUIRE(views.size() == 3);
  CHECK(views[0].azimuth == 0);
  CHECK(views[1].azimuth == 120);
  CHECK(views[2].azimuth == 240);
  cameras.resize(5);
  CHECK(probe_views(cameras).size() == 1);
}

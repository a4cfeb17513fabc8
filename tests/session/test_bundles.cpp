// Slices dealt in bundles: the same bits, in fewer payloads and hops.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "ringsplat/session/session.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int bundles[] = {1, 2, 3, 7, 1000};

Method splats_in_slices_plane() {
  Splats splats;
  splats.image_plane = ImagePlane::slices;
  return splats;
}

std::vector<FrameSpec> views_of(const Method& method) {
  std::vector<FrameSpec> specs;
  for (const double azimuth : {33.0, 123.0, 213.0, 303.0}) {
    specs.push_back(oblique_view(72, 60, 24));
    specs.back().how = method;
    specs.back().shown.camera.azimuth = azimuth;
    specs.back().shown.shading = azimuth < 180 ? Shading::phong : Shading::none;
  }
  return specs;
}

std::string text_of(const Layout& layout) {
  return fmt::format("{} GPs, {} Renderers, bundles of {}", layout.gps, layout.renderers, layout.bundle);
}

}  // namespace

TEST_CASE("bundles of any size give the same bits on any layout, with both engines") {
  const auto source = synth_source("jack", make_grid({33, 27, 30}));
  for (const Method& method : {Method(Splats{}), splats_in_slices_plane(), Method(Sheets{})})
    for (FrameSpec spec : views_of(method)) {
      const Image alone = render_loopback(*source, spec, 1, 1).image;
      REQUIRE(brightest(alone) > 0.1F);
      for (const int bundle : bundles)
        for (Layout layout : {Layout{1, 1}, Layout{2, 3}, Layout{5, 2}, Layout{40, 4},
                              Layout{3, 3, Placement::colocated}, mesh_layout(2, 2, 2)}) {
          layout.bundle = bundle;
          INFO(fmt::format("azimuth {}, {}", spec.shown.camera.azimuth, text_of(layout)));
          CHECK(render_loopback(*source, spec, layout).image == alone);
        }
    }
}

TEST_CASE("bundles give the same bits whatever the order of messages and however little room there is") {
  const auto source = synth_source("jack", make_grid({17, 15, 16}));
  const std::vector<FrameSpec> specs[] = {views_of(Splats{}), views_of(Sheets{})};
  std::vector<Image> alone;
  for (const auto& views : specs) alone.push_back(render_loopback(*source, views[2], 1, 1).image);
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const LoopbackOptions loopback{.seed = seed, .reorder = true, .max_delay = int(seed % 7)};
    Layout layout{std::array{1, 2, 3, 5, 8}[seed % 5], 1 + int(seed / 5) % 4,
                  seed % 2 == 0 ? Placement::dedicated : Placement::colocated};
    layout.bundle = bundles[seed / 2 % 5];
    const ProtocolOptions protocol{
        .slots = 1 + int(seed % 3), .look_ahead = 1 + int(seed / 3) % 3, .send_ahead = int(seed / 2 % 4)};
    INFO(fmt::format("seed {}, {}", seed, text_of(layout)));
    for (std::size_t engine = 0; engine < 2; ++engine)
      REQUIRE(render_loopback(*source, specs[engine][2], layout, loopback, protocol).image == alone[engine]);
  }
}

TEST_CASE("clip boxes cut bundles, and undersampled levels have bundles of their own") {
  const auto source = synth_source("jack", make_grid({33, 27, 30}));
  for (const Method& method : {Method(Splats{}), Method(Sheets{})})
    for (FrameSpec spec : views_of(method))
      for (const bool clipped : {true, false}) {
        if (clipped)
          spec.shown.clip = VoxelBox{{5, 3, 4}, {31, 22, 27}};
        else
          spec.shown.clip.reset();
        spec.shown.reduction = {clipped ? 1 : 2, !clipped};
        const Image alone = render_loopback(*source, spec, 1, 1).image;
        REQUIRE(brightest(alone) > 0.1F);
        for (const int bundle : bundles) {
          Layout layout{3, 2};
          layout.bundle = bundle;
          INFO(fmt::format("azimuth {}, {}", spec.shown.camera.azimuth, text_of(layout)));
          CHECK(render_loopback(*source, spec, layout).image == alone);
        }
      }
}

TEST_CASE("statistics count slices, and one token and payload for each bundle") {
  const auto source = synth_source("box", make_grid({24, 24, 30}));
  FrameSpec spec = oblique_view(72, 60, 24);
  spec.shown.camera = {};
  spec.shown.transfer_function = constant_opacity(0.1);
  const FrameResult single = render_loopback(*source, spec, 3, 1);
  REQUIRE(single.stats.slices == 24);  // seen from the front: along y
  REQUIRE(single.stats.total().payloads_sent == 24);
  for (const int bundle : {2, 5, 24, 1000}) {
    CAPTURE(bundle);
    Layout layout{3, 1};
    layout.bundle = bundle;
    const FrameResult result = render_loopback(*source, spec, layout);
    const NodeStats one = single.stats.total(), sum = result.stats.total();
    const auto steps = std::uint64_t((24 + bundle - 1) / bundle);
    CHECK(result.stats.slices == 24);
    CHECK(sum.slices == 24);
    CHECK(sum.payloads_sent == steps);
    CHECK(sum.payloads_drawn == steps);
    CHECK(sum.tokens_passed == steps - 1);
    CHECK(sum.splats_sent == one.splats_sent);
    CHECK(sum.visible_voxels == one.visible_voxels);
    CHECK(sum.passes == one.passes);
    const auto largest = std::uint64_t(std::min(24, bundle * int((steps + 2) / 3)));
    CHECK(result.stats.gps[0].slices == std::min<std::uint64_t>(24, largest));
  }
}

TEST_CASE("a session's blocks are dealt in bundles, too") {
  const auto source = synth_source("jack", make_grid({23, 20, 26}));
  std::vector<std::byte> voxels(source->grid().bytes());
  source->read_slices(0, 26, voxels);
  for (const Method& method : {Method(Splats{}), Method(Sheets{})})
    for (const FrameSpec& spec : views_of(method)) {
      const Image alone = render_loopback(*source, spec, 1, 1).image;
      for (const int bundle : bundles) {
        Layout layout{.gps = 3, .renderers = 2};
        layout.bundle = bundle;
        Session session({}, layout);
        session.set_grid(source->grid());
        session.add_block(whole_box(source->grid()), voxels.data());
        session.commit();
        INFO(text_of(layout));
        CHECK(session.render(spec) == alone);
      }
    }
}

TEST_CASE("sheets exchange fewer neighbours' ranges of cells with bundles") {
  const auto source = synth_source("jack", make_grid({17, 16, 48}));
  const auto known = [&](int bundle) {
    std::vector<std::byte> voxels(source->grid().bytes());
    source->read_slices(0, 48, voxels);
    SoloCollectives solo;
    OpenedVolume volume{source->grid(), true, memory_source(source->grid(), voxels)};
    auto stores =
        deal_slices(volume, {.kept_axes = {false, false, true}}, {{6, bundle}, std::vector<int>(6), solo});
    share_cell_ranges(stores, {{6, bundle}, std::vector<int>(6), solo});
    int count = 0;
    for (const auto& [gp, store] : stores)
      for (int s = 0; s < 48; ++s) count += store.cell_ranges(Axis::z, s) != nullptr;
    return count;
  };
  CHECK(known(1) == 48 * 5 - 6);  // its own slice and two to either side, where there are such
  CHECK(known(8) == 48 + 5 * 4);  // two on either side of each seam
}

TEST_CASE("a bundle without slices, or with more than any volume has, is refused") {
  const auto source = synth_source("jack", make_grid({17, 16, 20}));
  for (const int bundle : {0, -3, most_slices_of_bundle + 1}) {
    Layout layout{2, 1};
    layout.bundle = bundle;
    CHECK_THROWS_WITH(render_loopback(*source, oblique_view(24, 24, 24), layout),
                      Catch::Matchers::Contains("--bundle is " + std::to_string(bundle)));
  }
}

#include <fmt/format.h>

#include <map>
#include <random>
#include <set>

#include "net/loopback.hpp"
#include "protocol/rank.hpp"
#include "ringsplat/base/error.hpp"
#include "session/directed_frames.hpp"
#include "session/render_frames.hpp"
#include "support/catch.hpp"
#include "support/lock_step.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

std::string shape(const Layout& mesh) {
  return fmt::format("{}x{}+{}", mesh.mesh_columns, mesh.mesh_rows, mesh.renderers);
}

FrameSpec small_view(int size) {
  FrameSpec spec{.how = Splats{}};
  spec.shown.camera = {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2};
  spec.shown.width = spec.shown.height = size;
  spec.division.region_size = 8;
  spec.shown.transfer_function = ramp(20, 255, 0.3);
  return spec;
}

}  // namespace

TEST_CASE("a mesh gives the bits of one process, with hop by hop and with direct messages") {
  const auto source = synth_source("jack", make_grid({23, 19, 21}));
  FrameSpec spec = small_view(48);
  for (const double azimuth : {33.0, 213.0}) {
    spec.shown.camera.azimuth = azimuth;
    const Image alone = render_loopback(*source, spec, 1, 1).image;
    REQUIRE(brightest(alone) > 0.1F);
    for (const auto routing : {Routing::manhattan, Routing::direct})
      for (const Layout& mesh :
           {mesh_layout(2, 2, 2, routing), mesh_layout(3, 3, 3, routing), mesh_layout(4, 4, 8, routing),
            mesh_layout(2, 4, 4, routing), mesh_layout(5, 2, 3, routing), mesh_layout(1, 3, 6, routing),
            mesh_layout(4, 1, 1, routing)}) {
        INFO(shape(mesh));
        REQUIRE(render_loopback(*source, spec, mesh).image == alone);
      }
  }
}

TEST_CASE("a mesh gives the same bits for 1,000 seeds of delay and reordering") {
  const auto source = synth_source("jack", make_grid({9, 8, 7}));
  FrameSpec spec = small_view(20);
  spec.shown.shading = Shading::none;
  std::map<double, Image> alone;
  for (const double azimuth : {33.0, 213.0}) {
    spec.shown.camera.azimuth = azimuth;
    const Image& image = alone[azimuth] = render_loopback(*source, spec, 1, 1).image;
    REQUIRE(brightest(image) > 0.1F);
  }
  const std::array meshes{mesh_layout(2, 2, 2), mesh_layout(2, 2, 4), mesh_layout(3, 2, 3),
                          mesh_layout(2, 3, 6), mesh_layout(3, 3, 6)};
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const LoopbackOptions loopback{.seed = seed, .reorder = true, .max_delay = int(seed % 7)};
    const ProtocolOptions protocol{
        .slots = 1 + int(seed % 3), .link_slots = 1 + int(seed / 3 % 3), .look_ahead = 1 + int(seed / 9 % 2)};
    const Layout& mesh = meshes[seed % meshes.size()];
    spec.shown.camera.azimuth = seed / 5 % 2 == 0 ? 33.0 : 213.0;
    INFO(shape(mesh) << ", seed " << seed);
    REQUIRE(render_loopback(*source, spec, mesh, loopback, protocol).image ==
            alone[spec.shown.camera.azimuth]);
  }
}

TEST_CASE(
    "ten thousand frames over links and Renderers of one slot, with random delays and payload sizes, end") {
  // Noise: the threshold decides how many of the voxels are sent.
  const Grid grid = make_grid({5, 5, 5});
  std::vector<std::byte> voxels(grid.bytes());
  std::mt19937 noise(7);
  for (auto& voxel : voxels) voxel = std::byte(noise() % 256);
  const auto source = memory_source(grid, voxels);
  const std::array meshes{mesh_layout(2, 2, 2), mesh_layout(2, 2, 4), mesh_layout(3, 2, 4),
                          mesh_layout(2, 3, 6)};
  constexpr int frames = 2500;
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    std::mt19937 random(unsigned(k) + 1);
    int done = 0;
    std::set<std::uint64_t> sizes;
    const auto spec = [&](int frame) {
      FrameSpec s = small_view(8);
      s.shown.shading = Shading::none;
      s.division.region_size = 4;
      s.shown.camera.azimuth = 90.0 * double(frame % 4) + 7;
      s.shown.camera.zoom = 0.3 + double(random() % 16) / 10.0;
      s.shown.transfer_function = ramp(double(random() % 250), 255, 0.5);
      return s;
    };
    INFO(shape(meshes[k]));
    const auto next = [&, asked = 0]() mutable {
      return asked < frames ? std::optional(spec(asked++)) : std::nullopt;
    };
    const auto check_frame = [&](FrameResult&& result) {
      REQUIRE(result.spec.frame == done);
      sizes.insert(result.stats.total().payload_bytes_sent);
      ++done;
    };
    render_directed(*source, {}, meshes[k], {next, check_frame}, {.seed = k, .reorder = true, .max_delay = 3},
                    {.frames_in_flight = 1 + int(k % 3), .slots = 1, .link_slots = 1});
    CHECK(done == frames);
    CHECK(sizes.size() > 20);
  }
}

TEST_CASE("every link's traffic of a frame is in its statistics") {
  const auto source = synth_source("jack", make_grid({17, 15, 16}));
  const FrameSpec spec = small_view(48);
  for (const Layout& mesh : {mesh_layout(2, 2, 4), mesh_layout(3, 3, 3), mesh_layout(3, 2, 3)})
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const FrameStats stats =
          render_loopback(*source, spec, mesh, {.seed = seed, .reorder = true, .max_delay = 3},
                          {.link_slots = 1})
              .stats;
      const NodeStats nodes = stats.total();
      INFO(shape(mesh) << ", seed " << seed);
      REQUIRE(stats.links.size() == links(mesh).size());
      std::uint64_t into_renderers = 0, payload_bytes = 0, from_renderers = 0;
      for (const LinkCounts& link : stats.links) {
        const bool from_renderer = link.link.from >= mesh.gps;
        const bool to_renderer = neighbour(mesh, link.link.from, link.link.direction).value() >= mesh.gps;
        if (to_renderer) into_renderers += link.payloads;
        if (to_renderer) payload_bytes += link.payload_bytes;
        if (from_renderer) from_renderers += link.messages;
        CHECK(link.messages >= link.shared);
        CHECK(link.shared >= link.waited);
        CHECK((link.wait_seconds > 0) == (link.waited > 0));
      }
      CHECK(into_renderers == nodes.payloads_sent);
      CHECK(payload_bytes == nodes.payload_bytes_sent + nodes.payloads_sent * sizeof(Header));
      // An accept for each payload, the tiles, and one report each.
      CHECK(from_renderers == nodes.payloads_sent + nodes.tiles + std::uint64_t(mesh.renderers));
    }
  CHECK(render_loopback(*source, spec, mesh_layout(2, 2, 4, Routing::direct)).stats.links.empty());
  CHECK(render_loopback(*source, spec, 4, 4).stats.links.empty());
}

TEST_CASE("in step, a real frame uses no directed link twice for payloads, and its image is the same") {
  const auto source = synth_source("jack", make_grid({25, 23, 24}));
  FrameSpec spec = small_view(64);
  for (const double azimuth : {33.0, 123.0, 213.0, 303.0})
    for (const Layout& mesh : {mesh_layout(2, 2, 2), mesh_layout(2, 2, 4), mesh_layout(3, 3, 3),
                               mesh_layout(3, 3, 6), mesh_layout(4, 4, 8)}) {
      spec.shown.camera.azimuth = azimuth;
      std::map<std::pair<std::int64_t, Link>, int> uses;
      std::map<std::int64_t, std::set<int>> senders;
      // By step and column: rows of the GPs that send to the left and to the right.
      std::map<std::pair<std::int64_t, int>, std::map<bool, int>> rows;
      int payload_hops = 0;
      const auto on_link_use = [&](std::int64_t step, const Link& link, const Header& header) {
        if (header.kind != Kind::payload) return;
        ++payload_hops;
        ++uses[{step, link}];
        senders[step].insert(header.source);
        rows[{step, header.source % mesh.mesh_columns}][token_place(header)->renderer >= mesh.mesh_rows] =
            header.source / mesh.mesh_columns;
      };
      LockStep clock;
      const FrameResult result = render_loopback(
          *source, spec, mesh, in_step({.seed = 1, .reorder = true, .max_delay = 4}, clock, on_link_use));
      INFO(shape(mesh) << ", azimuth " << azimuth);
      int most = 0;
      for (const auto& [use, count] : uses) most = std::max(most, count);
      CHECK(most == 1);
      // Of a column's two active GPs the upper one sends up and to the right, the lower one down.
      for (const auto& [where, row_of] : rows)
        if (row_of.size() == 2) CHECK((row_of.at(true) + 1) % mesh.mesh_rows == row_of.at(false));
      std::size_t most_senders = 0;
      for (const auto& [step, gps] : senders) most_senders = std::max(most_senders, gps.size());
      CHECK(most_senders > 1);
      CHECK(std::uint64_t(payload_hops) == total(result.stats.links).payloads);
      CHECK(result.image == render_loopback(*source, spec, 1, 1).image);
    }
}

TEST_CASE("the watchdog ends a rank's run and says whom it waits for") {
  const auto source = synth_source("jack", make_grid({17, 15, 16}));
  const Layout mesh = mesh_layout(2, 2, 2);
  std::vector<std::byte> voxels(source->grid().bytes());
  source->read_slices(0, source->grid().dims.z, voxels);
  OpenedVolume volume{source->grid(), true, memory_source(source->grid(), voxels)};
  SoloCollectives solo;
  Scene scene = load_scene(volume, {}, mesh, {solo});
  LoopbackNetwork network(mesh.ranks());
  DirectedFrames frames({.next_frame = [] { return std::optional(small_view(48)); }, .frame_done = {}},
                        scene.grid, mesh);
  std::vector<std::unique_ptr<Engine>> engines;
  std::vector<std::unique_ptr<Host>> ranks;
  for (int rank = 0; rank < mesh.ranks(); ++rank) {
    engines.push_back(
        make_rank_engine({.grid = scene.grid,
                          .gps = mesh.gps,
                          .renderers = mesh.renderers,
                          .slices = std::make_shared<const SliceStore>(
                              rank < mesh.gps ? std::move(scene.stores.at(rank)) : SliceStore())}));
    ranks.push_back(
        std::make_unique<Host>(mesh, ProtocolOptions{.slots = 1, .link_slots = 1, .stall_timeout = 0.05},
                               network.transport(rank), *engines.back(), rank == 0 ? &frames : nullptr));
  }
  constexpr int stopped = 5;  // Renderer 1
  for (bool moved = true; moved; network.turn()) {
    moved = false;
    for (int rank = 0; rank < mesh.ranks(); ++rank)
      moved = (rank != stopped && ranks[std::size_t(rank)]->step()) || moved;
  }
  std::string report;
  for (const auto& rank : ranks) {
    if (rank->rank() == stopped) continue;
    try {
      rank->run();
    } catch (const RunError& e) {
      report += e.what();
    }
  }
  CHECK(report.find("nothing moved for 0.05 s: ") != std::string::npos);
  CHECK(report.find("waits for Renderer 1 to accept") != std::string::npos);
  CHECK(report.find("rank 5 has not yet handed on 1 message(s) from link x0y1W") != std::string::npos);
  CHECK(report.find("the frame buffer waits for reports on frame 0 from") != std::string::npos);
}

#include <fmt/format.h>
#include <mpi.h>

#include <array>

#include "mpi/connections.hpp"
#include "net/mesh.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

FrameSpec view(int frame) {
  FrameSpec spec{.how = Splats{}};
  spec.shown.camera = {.azimuth = 33 + 90.0 * frame, .elevation = 21, .roll = 8, .zoom = 1.2};
  spec.shown.width = spec.shown.height = 64;
  spec.division.region_size = 16;
  spec.shown.transfer_function = ramp(20, 255, 0.3);
  return spec;
}

constexpr int frames = 5;

/// Several frames, two under way at once, on the first ranks of the job; the images are on rank 0.
std::vector<FrameResult> render_on_ranks(const Layout& layout, const ProtocolOptions& protocol,
                                         VolumeSource& source) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank < layout.ranks() ? 0 : MPI_UNDEFINED, rank, &part);
  std::vector<FrameResult> results;
  if (part == MPI_COMM_NULL) return results;
  {
    const auto transport = make_mpi_transport(part);
    const auto collectives = make_mpi_collectives(part);
    const Wiring wiring{*collectives, transport.get()};
    OpenedVolume volume{source.grid(), false, nullptr};
    std::vector<std::byte> voxels(rank == 0 ? source.grid().bytes() : 0);
    if (rank == 0) {
      source.read_slices(0, source.grid().dims.z, voxels);
      volume.source = memory_source(source.grid(), voxels);
    }
    Scene scene = load_scene(volume, {}, layout, wiring);
    int asked = 0;
    Director director{[&]() -> std::optional<FrameSpec> {
                        return asked < frames ? std::optional(view(asked++)) : std::nullopt;
                      },
                      [&](FrameResult&& result) { results.push_back(std::move(result)); }};
    render_frames(std::move(scene), layout, protocol, std::move(director), wiring);
  }
  MPI_Comm_free(&part);
  return results;
}

}  // namespace

TEST_CASE("meshes on MPI give the bits of one process, with links of one slot and of several, and directly") {
  int rank = 0, ranks = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const auto source = synth_source("jack", make_grid({25, 22, 24}));
  std::vector<Image> alone;
  for (int k = 0; k < frames && rank == 0; ++k)
    alone.push_back(render_loopback(*source, view(k), 1, 1).image);
  int compared = 0;
  for (const auto& [columns, rows, renderers] :
       {std::array{2, 2, 2}, std::array{2, 2, 3}, std::array{2, 2, 4}, std::array{3, 2, 1},
        std::array{2, 3, 6}, std::array{3, 3, 3}, std::array{4, 4, 4}, std::array{4, 4, 8}})
    for (const auto routing : {Routing::manhattan, Routing::direct})
      for (const int link_slots : {1, 4}) {
        const Layout mesh = mesh_layout(columns, rows, renderers, routing);
        if (mesh.ranks() > ranks) continue;
        const auto results =
            render_on_ranks(mesh, {.slots = 1 + link_slots / 4, .link_slots = link_slots}, *source);
        INFO(fmt::format("{}x{}+{}, {} slot(s) a link", columns, rows, renderers, link_slots));
        REQUIRE((rank != 0 || results.size() == frames));
        for (std::size_t k = 0; k < results.size(); ++k) {
          REQUIRE(results[k].image == alone[k]);
          const FrameStats& stats = results[k].stats;
          REQUIRE(stats.links.size() == (mesh.routed() ? links(mesh).size() : 0));
          std::uint64_t into_renderers = 0;
          for (const LinkCounts& link : stats.links)
            if (neighbour(mesh, link.link.from, link.link.direction).value() >= mesh.gps)
              into_renderers += link.payloads;
          REQUIRE(into_renderers == (mesh.routed() ? stats.total().payloads_sent : 0));
        }
        ++compared;
      }
  REQUIRE(compared >= 4);
}

TEST_CASE("the mesh's neighbours are those of MPI's Cartesian communicator") {
  int rank = 0, ranks = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (const Layout& mesh : {mesh_layout(2, 2, 2), mesh_layout(3, 2, 4), mesh_layout(2, 3, 6),
                             mesh_layout(4, 4, 8), mesh_layout(4, 4, 4)}) {
    if (mesh.gps > ranks) continue;
    const std::array sizes{mesh.mesh_rows, mesh.mesh_columns}, periods{wraps(mesh) ? 1 : 0, 0};
    MPI_Comm cartesian = MPI_COMM_NULL;
    MPI_Cart_create(MPI_COMM_WORLD, 2, sizes.data(), periods.data(), 0, &cartesian);
    if (cartesian == MPI_COMM_NULL) continue;
    std::array<int, 2> place{};
    MPI_Cart_coords(cartesian, rank, 2, place.data());
    REQUIRE(place_of(mesh, rank) == MeshPlace{place[1], place[0]});
    const auto same = [&](int mpi_rank, Direction direction) {
      const auto ours = neighbour(mesh, rank, direction);
      // MPI has no neighbour beyond the edge, where our mesh may have a Renderer.
      if (mpi_rank == MPI_PROC_NULL) return !ours || *ours >= mesh.gps;
      return ours == mpi_rank;
    };
    std::array<int, 4> shifted{};
    MPI_Cart_shift(cartesian, 0, 1, &shifted[0], &shifted[1]);
    MPI_Cart_shift(cartesian, 1, 1, &shifted[2], &shifted[3]);
    REQUIRE(same(shifted[0], Direction::north));
    REQUIRE(same(shifted[1], Direction::south));
    REQUIRE(same(shifted[2], Direction::west));
    REQUIRE(same(shifted[3], Direction::east));
    MPI_Comm_free(&cartesian);
  }
}

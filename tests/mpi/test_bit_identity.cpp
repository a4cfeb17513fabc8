#include <fmt/format.h>
#include <mpi.h>

#include "mpi/connections.hpp"
#include "support/catch.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

FrameSpec view_from(double azimuth) {
  FrameSpec spec = oblique_view(96, 80, 24);
  spec.shown.camera.azimuth = azimuth;
  return spec;
}

/// Renders on the first layout.ranks() ranks of the job; the image is on rank 0.
Image render_on_ranks(const Layout& layout, const FrameSpec& spec, VolumeSource& source,
                      const EngineOptions& engine = {}) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank < layout.ranks() ? 0 : MPI_UNDEFINED, rank, &part);
  Image image;
  if (part == MPI_COMM_NULL) return image;
  {
    const auto transport = make_mpi_transport(part);
    const auto collectives = make_mpi_collectives(part);
    const Grid grid = source.grid();
    std::vector<std::byte> voxels(rank == 0 ? grid.bytes() : 0);
    if (rank == 0) source.read_slices(0, grid.dims.z, voxels);
    image = render_image(grid, voxels, spec, layout, {*collectives, transport.get()}, engine);
  }
  MPI_Comm_free(&part);
  return image;
}

}  // namespace

TEST_CASE("the image has the same bits on any number of ranks as in one process") {
  int rank = 0, ranks = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const auto source = synth_source("jack", make_grid({25, 22, 24}));
  int compared = 0;
  for (const double azimuth : {33.0, 123.0}) {
    const FrameSpec spec = view_from(azimuth);
    Image alone;
    if (rank == 0) alone = render_loopback(*source, spec, 1, 1).image;
    for (const auto placement : {Placement::dedicated, Placement::colocated})
      for (const int gps : {1, 2, 3, 5, 8})
        for (const int renderers : {1, 2, 3, 4}) {
          const Layout layout{gps, renderers, placement};
          if (layout.ranks() > ranks) continue;
          const Image image = render_on_ranks(layout, spec, *source);
          INFO(fmt::format("azimuth {}, {} GPs, {} Renderers, {} ranks", azimuth, gps, renderers,
                           layout.ranks()));
          REQUIRE((rank != 0 || image == alone));
          ++compared;
        }
  }
  REQUIRE(compared >= 2);
}

TEST_CASE("bundles of any size give the same bits on ranks, with both engines") {
  int rank = 0, ranks = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const auto source = synth_source("jack", make_grid({25, 22, 24}));
  for (const Method& method : {Method(Splats{}), Method(Sheets{})}) {
    FrameSpec spec = view_from(213);
    spec.how = method;
    Image alone;
    if (rank == 0) alone = render_loopback(*source, spec, 1, 1).image;
    for (Layout layout : {Layout{2, 1}, Layout{3, 3, Placement::colocated}, Layout{3, 2}}) {
      if (layout.ranks() > ranks) continue;
      for (const int bundle : {1, 2, 3, 7, 1000}) {
        layout.bundle = bundle;
        const Image image = render_on_ranks(layout, spec, *source);
        INFO(fmt::format("{} GPs, {} Renderers, bundles of {}", layout.gps, layout.renderers, bundle));
        REQUIRE((rank != 0 || image == alone));
      }
    }
  }
}

TEST_CASE("idle ranks take no part, frame after frame") {
  int rank = 0, ranks = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const auto source = synth_source("jack", make_grid({25, 22, 24}));
  for (const double azimuth : {33.0, 123.0}) {
    const FrameSpec spec = view_from(azimuth);
    Image alone;
    if (rank == 0) alone = render_loopback(*source, spec, 1, 1).image;
    for (Layout layout :
         {Layout{1, 1}, Layout{2, 2, Placement::colocated}, Layout{1, 1, Placement::colocated}}) {
      if (layout.ranks() > ranks) continue;
      layout.idle = ranks - layout.ranks();
      const Image image = render_on_ranks(layout, spec, *source);
      INFO(fmt::format("azimuth {}, {} of {} ranks idle", azimuth, layout.idle, ranks));
      CHECK((rank != 0 || image == alone));
    }
  }
}

TEST_CASE("threads that share the work of ranks keep the bits") {
  int rank = 0, ranks = 0, level = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  MPI_Query_thread(&level);
  REQUIRE(level >= MPI_THREAD_FUNNELED);
  if (ranks > 3) return;
  const auto source = synth_source("jack", make_grid({65, 62, 64}));
  FrameSpec spec = view_from(33);
  spec.shown.width = spec.shown.height = 300;
  for (const auto plane : {ImagePlane::screen, ImagePlane::slices}) {
    spec.as<Splats>().image_plane = plane;
    Image alone;
    if (rank == 0) alone = render_loopback(*source, spec, 1, 1).image;
    for (const Layout& layout : {Layout{1, 1}, Layout{2, 2, Placement::colocated}})
      for (const int threads : {1, 2, 3, 8}) {
        const Image image = render_on_ranks(layout, spec, *source, {.threads_per_rank = threads});
        INFO(fmt::format("plane {}, {} threads on each of {} ranks", int(plane), threads, layout.ranks()));
        REQUIRE((rank != 0 || image == alone));
      }
  }
}

// Solves the heat equation on the job's ranks, which also draw it every tenth step:
//
//     mpirun -n 8 heat FOLDER [CELLS [STEPS]]
//
// The pictures are FOLDER/heat-0000.png and so on.
#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>

#include "heat_equation.hpp"
#include "ringsplat/ringsplat.hpp"

namespace {

/// Grey smoke where it is warm, glowing where it is hot.
ringsplat::TransferFunction glow() {
  ringsplat::TransferFunction function;
  function.name = "glow";
  function.colours = {{0, {0.1, 0.1, 0.4}}, {0.3, {0.7, 0.1, 0.1}}, {1.5, {1, 0.6, 0.1}}, {4, {1, 1, 0.8}}};
  function.opacities = {{0.01, 0}, {0.3, 0.01}, {1.5, 0.06}, {4, 0.3}};
  return function;
}

ringsplat::FrameSpec view(int frame) {
  ringsplat::FrameSpec spec;
  spec.how = ringsplat::Sheets{};
  spec.shown.transfer_function = glow();
  spec.shown.camera.azimuth = 20 + 0.5 * frame;
  spec.shown.camera.elevation = 25;
  return spec;
}

ringsplat::Grid lattice(int cells) {
  ringsplat::Grid grid;
  grid.dims = glm::ivec3(cells);
  grid.spacing = glm::dvec3(1.0 / cells);
  grid.type = ringsplat::ScalarType::float32;
  return grid;
}

/// Where the solver's cells lie, without the ghosts around them.
void add_cells(ringsplat::Session& session, const HeatEquation& heat) {
  const auto& [x0, y0, z0] = heat.first();
  const auto& [x1, y1, z1] = heat.end();
  session.set_grid(lattice(heat.cells()));
  if (x0 == x1 || y0 == y1 || z0 == z1) return;
  constexpr std::ptrdiff_t bytes = sizeof(float);
  session.add_block({{x0, y0, z0}, {x1, y1, z1}}, heat.temperature(),
                    ringsplat::Strides{bytes, bytes * heat.row(), bytes * heat.plane()});
}

struct Seconds {
  double solving = 0, committing = 0, rendering = 0, writing = 0;
};

/// Adds to `sum` what `work` takes until all ranks have done it.
template <class Work>
void timed(MPI_Comm comm, double& sum, const Work& work) {
  const double begin = MPI_Wtime();
  work();
  MPI_Barrier(comm);
  sum += MPI_Wtime() - begin;
}

void run(const std::filesystem::path& folder, int cells, int steps) {
  HeatEquation heat(MPI_COMM_WORLD, cells);
  ringsplat::Session session(heat.comm());
  if (session.rank() == 0) std::filesystem::create_directories(folder);
  Seconds seconds;
  const glm::dvec3 black(0.0);
  for (int step = 1; step <= steps; ++step) {
    timed(heat.comm(), seconds.solving, [&] { heat.step(); });
    if (step % 10 != 0) continue;
    const int frame = step / 10 - 1;
    ringsplat::Image image;
    timed(heat.comm(), seconds.committing, [&] {
      add_cells(session, heat);
      session.commit();
    });
    timed(heat.comm(), seconds.rendering, [&] { image = session.render(view(frame)); });
    char name[32];
    std::snprintf(name, sizeof name, "heat-%04d.png", frame);
    timed(heat.comm(), seconds.writing, [&] {
      if (session.rank() == 0) ringsplat::write_image(image, folder / name, black);
    });
  }
  if (session.rank() == 0)
    std::printf(
        "%d steps of %d^3 cells on %d ranks: solving %.2f s, committing %.2f s, rendering %.2f s, writing "
        "%.2f s\n",
        steps, cells, session.ranks(), seconds.solving, seconds.committing, seconds.rendering,
        seconds.writing);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  if (argc < 2) {
    std::fprintf(stderr, "usage: mpirun -n RANKS %s FOLDER [CELLS [STEPS]]\n", argv[0]);
    MPI_Abort(MPI_COMM_WORLD, 2);
  }
  try {
    run(argv[1], argc > 2 ? std::atoi(argv[2]) : 96, argc > 3 ? std::atoi(argv[3]) : 600);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "heat: %s\n", e.what());
    MPI_Abort(MPI_COMM_WORLD, 3);
  }
  MPI_Finalize();
}

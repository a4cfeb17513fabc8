// Solves the heat equation while browsers look on, turn it and change how strongly it is heated:
//
//     mpirun -n 4 heat_live [CELLS [STEPS [PORT]]]
//
// It prints the page's address. SHARE in the environment is the part of its time that pictures may take, and
// SET_ASIDE how many ranks draw and leave the others alone.
#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>

#include "heat_volume.hpp"

namespace {

ringsplat::LiveOptions options(int port) {
  ringsplat::LiveOptions options;
  options.name = "heat";
  options.port = port;
  if (const char* share = std::getenv("SHARE")) options.share = std::atof(share);
  ringsplat::FrameSpec& first = options.frame.emplace();
  first.shown.transfer_function = glow();
  first.shown.camera.azimuth = 20;
  first.shown.camera.elevation = 25;
  return options;
}

void run(int cells, int steps, int port) {
  const char* aside = std::getenv("SET_ASIDE");
  ringsplat::Session session(MPI_COMM_WORLD, {}, {.visualisation_ranks = aside ? std::atoi(aside) : 0});
  MPI_Comm solvers = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, session.visualises() ? MPI_UNDEFINED : 0, session.rank(), &solvers);
  std::optional<HeatEquation> heat;
  session.set_grid(lattice(cells));
  if (!session.visualises()) {
    add_cells(session, heat.emplace(solvers, cells));
    MPI_Comm_free(&solvers);
  }
  session.commit();
  ringsplat::Live live(session, options(port));
  double heating = 1;
  live.offer("heating", heating, 0, 10);
  if (!live.url().empty()) {
    std::printf("%s\n", live.url().c_str());
    std::fflush(stdout);
  }
  if (session.visualises()) return live.visualise();
  const double begin = MPI_Wtime();
  for (int step = 1; step <= steps; ++step) {
    heat->step(float(heating));
    if (heat->has_cells()) session.update_block(0, heat->temperature());
    live.show(step, heat->time());
  }
  if (session.rank() > 0) return;
  const double seconds = MPI_Wtime() - begin;
  std::printf("%d steps, %.3f s, %d handed over\n", steps, seconds, int(live.handed_over()));
}

int number(int argc, char** argv, int index, int otherwise) {
  return argc > index ? std::atoi(argv[index]) : otherwise;
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  try {
    run(number(argc, argv, 1, 96), number(argc, argv, 2, 1'000'000), number(argc, argv, 3, 0));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "heat_live: %s\n", e.what());
    MPI_Abort(MPI_COMM_WORLD, 3);
  }
  MPI_Finalize();
}

// Solves the heat equation while browsers look on, turn it and change how strongly it is heated:
//
//     mpirun -n 4 heat_live [CELLS [STEPS [PORT]]]
//
// It prints the page's address. SHARE in the environment is the part of its time that pictures may take,
// SET_ASIDE how many ranks draw and have no cells.
#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <exception>

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

/// The ranks that have cells.
MPI_Comm solvers_of(const ringsplat::Session& session) {
  MPI_Comm solvers = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, session.visualises() ? 1 : 0, session.rank(), &solvers);
  return solvers;
}

void solve(ringsplat::Session& session, ringsplat::Live& live, HeatEquation& heat, int steps,
           const double& heating) {
  const double begin = MPI_Wtime();
  for (int step = 1; step <= steps; ++step) {
    heat.step(float(heating));
    if (heat.has_cells()) session.update_block(0, heat.temperature());
    live.show(step, heat.time());
  }
  int rank = 0;
  MPI_Comm_rank(heat.comm(), &rank);
  if (rank == 0) std::printf("%d steps, %.3f s\n", steps, MPI_Wtime() - begin);
}

void run(int cells, int steps, int port) {
  const char* aside = std::getenv("SET_ASIDE");
  ringsplat::Session session(MPI_COMM_WORLD, {}, {.visualisation_ranks = aside ? std::atoi(aside) : 0});
  MPI_Comm solvers = solvers_of(session);
  HeatEquation heat(solvers, cells);
  MPI_Comm_free(&solvers);
  session.set_grid(lattice(cells));
  if (!session.visualises()) add_cells(session, heat);
  session.commit();
  ringsplat::Live live(session, options(port));
  double heating = 1;
  live.offer("heating", heating, 0, 10);
  if (session.rank() == 0) {
    std::printf("%s\n", live.url().c_str());
    std::fflush(stdout);
  }
  if (session.visualises())
    live.visualise();
  else
    solve(session, live, heat, steps, heating);
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

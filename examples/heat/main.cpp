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

#include "heat_volume.hpp"

namespace {

ringsplat::FrameSpec view(int frame) {
  ringsplat::FrameSpec spec;
  spec.shown.transfer_function = glow();
  spec.shown.camera.azimuth = 20 + 0.5 * frame;
  spec.shown.camera.elevation = 25;
  return spec;
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

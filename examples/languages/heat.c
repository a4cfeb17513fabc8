/* The heat equation on slabs of a cube, drawn and shown by Ringsplat from C:
 *
 *     mpirun -n 3 heat_c PICTURE [STEPS [PICTURES.toml]]
 *
 * It prints a page's address, on which the run can be watched and the heating changed. A file may ask for more
 * pictures while it runs. */
#include <mpi.h>
#include <ringsplat/ringsplat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { cells = 32, row = cells + 2, plane = row * row };

static void check(int status) {
  if (status == 0) return;
  fprintf(stderr, "heat: %s\n", ringsplat_message());
  MPI_Abort(MPI_COMM_WORLD, status);
}

/* Planes 0 and depth + 1 are the neighbours'; outside the cube all is cold. */
static void exchange(float* t, int depth, int before, int after) {
  MPI_Sendrecv(t + plane, plane, MPI_FLOAT, before, 0, t + (depth + 1) * plane, plane, MPI_FLOAT, after, 0,
               MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  MPI_Sendrecv(t + depth * plane, plane, MPI_FLOAT, after, 1, t, plane, MPI_FLOAT, before, 1, MPI_COMM_WORLD,
               MPI_STATUS_IGNORE);
}

static void step(const float* t, float* next, int depth, int first, float heating) {
  for (int z = 1; z <= depth; ++z)
    for (int y = 1; y <= cells; ++y)
      for (int x = 1; x <= cells; ++x) {
        const int k = z * plane + y * row + x;
        const float around = t[k - 1] + t[k + 1] + t[k - row] + t[k + row] + t[k - plane] + t[k + plane];
        const int heats = abs(first + z - cells / 2) < 3 && abs(y - cells / 3) < 3 && abs(x - cells / 2) < 3;
        next[k] = t[k] + (around - 6 * t[k]) / 8 + (heats ? heating : 0);
      }
}

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank, ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int first = cells * rank / ranks, depth = cells * (rank + 1) / ranks - first;
  const int before = rank > 0 ? rank - 1 : MPI_PROC_NULL, after = rank + 1 < ranks ? rank + 1 : MPI_PROC_NULL;
  const size_t bytes = sizeof(float) * plane * (size_t)(depth + 2);
  float *t = calloc(1, bytes), *next = calloc(1, bytes);

  const int32_t dims[3] = {cells, cells, cells}, begin[3] = {0, 0, first}, end[3] = {cells, cells, first + depth};
  const int64_t strides[3] = {sizeof(float), sizeof(float) * row, sizeof(float) * plane};
  const int inside = plane + row + 1;
  ringsplat_session* session;
  check(ringsplat_open(MPI_Comm_c2f(MPI_COMM_WORLD), &session));
  check(ringsplat_set_grid(session, dims, "float32", NULL, NULL));
  check(ringsplat_add_block(session, begin, end, t + inside, strides));
  check(ringsplat_commit(session));
  check(ringsplat_serve(session, "--tf=grey --range=0:2", 0, 0.05));
  double heating = 0.1;
  check(ringsplat_offer(session, "heating", &heating, 0, 1));
  if (rank == 0) printf("%s\n", ringsplat_url(session)), fflush(stdout);

  const int steps = argc > 2 ? atoi(argv[2]) : 100;
  for (int k = 1; k <= steps; ++k) {
    exchange(t, depth, before, after);
    step(t, next, depth, first, (float)heating);
    float* const old = t;
    t = next;
    next = old;
    check(ringsplat_update_block(session, 0, t + inside, NULL));
    check(ringsplat_show(session, k, 0.125 * k));
    if (argc > 3) check(ringsplat_act(session, argv[3], k));
  }
  check(ringsplat_commit(session));
  if (argc > 1) check(ringsplat_render(session, "--tf=grey --range=0:2 --size=256 --background=black", argv[1]));
  ringsplat_close(session);
  free(t);
  free(next);
  MPI_Finalize();
}

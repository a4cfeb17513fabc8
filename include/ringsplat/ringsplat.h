/* Ringsplat in C and, by the module in ringsplat/ringsplat.f90, in Fortran: a session draws a volume that
 * lies in blocks on the ranks of an MPI program, as ringsplat::Session does (ringsplat/session/session.hpp).
 *
 *     ringsplat_session* session;
 *     ringsplat_open(MPI_Comm_c2f(MPI_COMM_WORLD), &session);
 *     ringsplat_set_grid(session, dims, "float32", NULL, NULL);
 *     ringsplat_add_block(session, first, end, values, NULL);
 *     ringsplat_commit(session);
 *     ringsplat_render(session, "--tf=mr-soft --azimuth=30", "picture.png");
 *     ringsplat_close(session);
 *
 * Sizes, places and strides are along x, y, z. All functions but ringsplat_message() and ringsplat_url()
 * return 0, or RINGSPLAT_INPUT_ERROR or RINGSPLAT_RUN_ERROR. What one rank gets wrong is returned by the next
 * collective call on all, and the session can be used on; after a run error it cannot. */
#ifndef RINGSPLAT_H
#define RINGSPLAT_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { RINGSPLAT_INPUT_ERROR = 2, RINGSPLAT_RUN_ERROR = 3 };
/* In place of a communicator: this process alone. */
enum { RINGSPLAT_ALONE = -1 };

typedef struct ringsplat_session ringsplat_session;

/* What went wrong in this thread's last call that returned an error, and what to do. */
const char* ringsplat_message(void);

/* `communicator`: as Fortran has it. Collective. */
int ringsplat_open(int communicator, ringsplat_session** session);
/* Collective; NULL is nothing. */
void ringsplat_close(ringsplat_session* session);

/* The whole volume: voxels, their type (int8 uint8 int16 uint16 int32 uint32 float32 float64), distances and
 * the first one's place; NULL: 1 and 0. Removes the blocks. */
int ringsplat_set_grid(ringsplat_session* session, const int32_t dims[3], const char* type,
                       const double spacing[3], const double origin[3]);
/* Adds one of this rank's blocks: the voxels from `first` to before `end`, without ghosts. `strides` are the
 * bytes from a voxel to its neighbours; NULL: x is the fastest, without gaps. Blocks are numbered from 0. */
int ringsplat_add_block(ringsplat_session* session, const int32_t first[3], const int32_t end[3],
                        const void* first_voxel, const int64_t strides[3]);
/* Where a block's voxels lie now; `strides` as they were when NULL. */
int ringsplat_update_block(ringsplat_session* session, int block, const void* first_voxel,
                           const int64_t strides[3]);
/* Reads all blocks. Collective. */
int ringsplat_commit(ringsplat_session* session);

/* Draws the volume and has rank 0 write the picture. `options`: those of `ringsplat render` that describe a
 * picture, each as --name=value, as in "--tf=mr-soft --size=800x600"; rank 0's count. Collective. */
int ringsplat_render(ringsplat_session* session, const char* options, const char* file);

/* Draws the pictures that a TOML file asks for after this step, of the blocks as they are now. The file is read
 * at each step and may be changed while the program runs. A section is a picture: its keys are `every` so many
 * steps, the `first` step, `file` (where {step} is the step's number), and options of `ringsplat render`. What
 * is wrong in it is warned of on rank 0. Collective. */
int ringsplat_act(ringsplat_session* session, const char* file, int64_t step);

/* Shows the volume in browsers from now on (ringsplat/live/live.hpp), from `port` on, or any where it is 0;
 * pictures may hold the program up for `share` of the time that it takes itself, 0.05 for instance. All ranks
 * pass the same. Collective. */
int ringsplat_serve(ringsplat_session* session, const char* options, int port, double share);
/* The page's address on rank 0, elsewhere an empty text; until the next ringsplat_serve() or the end. */
const char* ringsplat_url(ringsplat_session* session);
/* Lets pages change `value` between `low` and `high`; it must outlive the session. */
int ringsplat_offer(ringsplat_session* session, const char* name, double* value, double low, double high);
/* Shows the blocks as they are now. Collective. */
int ringsplat_show(ringsplat_session* session, int64_t step, double time);

#ifdef __cplusplus
}
#endif
#endif

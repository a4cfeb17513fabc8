#pragma once
#include <mpi.h>

#include "ringsplat/net/processes.hpp"

namespace ringsplat {

/// Lets Session and Processes be made of an MPI_Comm. MPI must be initialised, with MPI_THREAD_FUNNELED or
/// more where threads_per_rank is above 1, and finalised after the object is gone. What goes wrong in MPI is
/// thrown as RunError; the communicator and its error handler stay as they are.
template <>
Processes connected<MPI_Comm>(MPI_Comm comm);

}  // namespace ringsplat

#include "mpi/connections.hpp"
#include "ringsplat/mpi/communicator.hpp"

namespace ringsplat {

template <>
Processes connected<MPI_Comm>(MPI_Comm comm) {
  auto collectives = make_mpi_collectives(comm);
  const bool alone = collectives->processes() == 1;
  return {std::move(collectives), alone ? nullptr : make_mpi_transport(comm)};
}

}  // namespace ringsplat

#include "mpi/communicator_handle.hpp"

#include "ringsplat/mpi/communicator.hpp"

namespace ringsplat {

std::size_t communicator_handle_bytes() { return sizeof(MPI_Comm); }

Processes connected_at(const void* communicator) {
  return connected<MPI_Comm>(*static_cast<const MPI_Comm*>(communicator));
}

}  // namespace ringsplat

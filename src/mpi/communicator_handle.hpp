#pragma once
#include <cstddef>

#include "ringsplat/net/processes.hpp"

/// Communicators of other languages, without mpi.h.
namespace ringsplat {

std::size_t communicator_handle_bytes();

/// Connects the processes of the MPI_Comm at this address, as connected() does
/// (ringsplat/mpi/communicator.hpp).
Processes connected_at(const void* communicator);

}  // namespace ringsplat

#pragma once
#include <IceT.h>
#include <mpi.h>

#include <cstdint>

namespace ringsplat::sort_last {

/// What went through a communicator, and what it costs on a simulated machine.
struct Traffic {
  int weight = 1;  ///< each byte stands for so many, on links that are as much slower than they should be
  double seconds_per_byte = 0;   ///< charged to the receiver for each byte that it has to composite or copy
  double send = 0, receive = 0;  ///< seconds of software charged on either side of a message
  std::uint64_t messages = 0, bytes = 0;  ///< sent so far, bytes with their weight
};

/// A communicator of IceT's on MPI, of this machine or simulated. In a simulation all ranks share IceT's
/// current context, as they share the library's globals, so it is set again whenever a call of MPI returns.
/// `traffic` must outlive the communicator and its duplicates.
IceTCommunicator make_icet_communicator(MPI_Comm comm, Traffic& traffic);
void destroy_icet_communicator(IceTCommunicator communicator);

}  // namespace ringsplat::sort_last

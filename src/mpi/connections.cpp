#include "mpi/connections.hpp"

#include <fmt/format.h>

#include <string>

#include "mpi/session.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/mpi/communicator.hpp"

namespace ringsplat {

void checked(int code, const char* call) {
  if (code == MPI_SUCCESS) return;
  char words[MPI_MAX_ERROR_STRING] = {};
  int length = 0, rank = -1;
  MPI_Error_string(code, words, &length);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  throw RunError(
      fmt::format("{} failed on rank {}: {}", call, rank, std::string(words, std::size_t(length))));
}

std::optional<int> take_signal(MPI_Comm comm, int source, int tag) {
  int arrived = 0;
  MPI_Message matched = MPI_MESSAGE_NULL;
  MPI_Status status;
  checked(MPI_Improbe(source, tag, comm, &arrived, &matched, &status), "MPI_Improbe");
  if (arrived == 0) return std::nullopt;
  checked(MPI_Mrecv(nullptr, 0, MPI_BYTE, &matched, MPI_STATUS_IGNORE), "MPI_Mrecv");
  return status.MPI_SOURCE;
}

OwnedComm::OwnedComm(MPI_Comm original) {
  checked(MPI_Comm_dup(original, &comm_), "MPI_Comm_dup");
  checked(MPI_Comm_set_errhandler(comm_, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  checked(MPI_Comm_rank(comm_, &rank_), "MPI_Comm_rank");
  checked(MPI_Comm_size(comm_, &ranks_), "MPI_Comm_size");
}

OwnedComm::~OwnedComm() {
  int finalised = 0;
  MPI_Finalized(&finalised);
  if (finalised == 0 && comm_ != MPI_COMM_NULL) MPI_Comm_free(&comm_);
}

std::size_t communicator_handle_bytes() { return sizeof(MPI_Comm); }

Processes connected_at(const void* communicator) {
  return connected<MPI_Comm>(*static_cast<const MPI_Comm*>(communicator));
}

template <>
Processes connected<MPI_Comm>(MPI_Comm comm) {
  auto collectives = make_mpi_collectives(comm);
  const bool alone = collectives->processes() == 1;
  return {std::move(collectives), alone ? nullptr : make_mpi_transport(comm)};
}

}  // namespace ringsplat

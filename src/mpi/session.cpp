#include "mpi/session.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <thread>

#include "base/clock.hpp"
#include "base/lack_of_memory.hpp"
#include "base/log.hpp"
#include "mpi/connections.hpp"
#include "net/launcher.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/mpi/communicator.hpp"

namespace ringsplat {
namespace {

int rank_in_world() {
  int rank = -1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

}  // namespace

MpiSession::MpiSession(int& argc, char**& argv) {
  // With less MPI may fail without a word of ours, or ranks may wait for each other for ever.
  constexpr std::size_t mpi_takes = std::size_t{240} << 20;
  if (!simulated() && !has_address_space(mpi_takes)) throw std::bad_alloc();
  int provided = 0;
  // Serialised, for the watch over ranks that read (collectives.cpp).
  checked(MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &provided), "MPI_Init_thread");
  // SimGrid promises no thread level. Its ranks are contexts of one process, and threads that do not call MPI
  // do not disturb it.
  if (provided < MPI_THREAD_FUNNELED && !simulated()) {
    MPI_Finalize();
    throw RunError("this MPI allows no thread beside the one that calls it, but pictures are written by one",
                   "use an MPI library with MPI_THREAD_FUNNELED");
  }
  if (!simulated()) return;
  clock_in_use = [] { return MPI_Wtime(); };
  log_rank_in_use = rank_in_world;
}

MpiSession::~MpiSession() { MPI_Finalize(); }

std::unique_ptr<Transport> MpiSession::make_transport() { return make_mpi_transport(MPI_COMM_WORLD); }
std::unique_ptr<Collectives> MpiSession::make_collectives() { return make_mpi_collectives(MPI_COMM_WORLD); }

std::vector<std::string> MpiSession::introductions(const std::string& mine) const {
  // Other builds rely on the size and on the closing zero.
  constexpr std::size_t size = 128;
  std::array<char, size> text{};
  mine.copy(text.data(), size - 1);
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  std::vector<char> all(size * std::size_t(ranks));
  checked(MPI_Allgather(text.data(), int(size), MPI_CHAR, all.data(), int(size), MPI_CHAR, MPI_COMM_WORLD),
          "MPI_Allgather (introductions)");
  std::vector<std::string> said;
  for (std::size_t at = 0; at < all.size(); at += size)
    said.emplace_back(all.data() + at, ::strnlen(all.data() + at, size));
  return said;
}

void MpiSession::abort(int exit_code) {
  // Launchers may forget, as MPICH's does, what a rank wrote just before it ended the job.
  std::fflush(nullptr);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::abort();
}

bool MpiSession::launched() { return simulated() || started_by_launcher(); }

std::string MpiSession::library() {
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
  int length = 0;
  checked(MPI_Get_library_version(text.data(), &length), "MPI_Get_library_version");
  std::string all(text.data(), std::size_t(length));
  std::replace(all.begin(), all.end(), '\t', ' ');  // MPICH's
  return all.substr(0, all.find_first_of(",\n"));
}

void checked(int code, const char* call) {
  if (code == MPI_SUCCESS) return;
  char words[MPI_MAX_ERROR_STRING] = {};
  int length = 0;
  MPI_Error_string(code, words, &length);
  throw RunError(fmt::format("{} failed on rank {}: {}", call, rank_in_world(), words));
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

Processes connected_by_number(int communicator) {
  return connected<MPI_Comm>(MPI_Comm_f2c(MPI_Fint(communicator)));
}

template <>
Processes connected<MPI_Comm>(MPI_Comm comm) {
  auto collectives = make_mpi_collectives(comm);
  const bool alone = collectives->processes() == 1;
  return {std::move(collectives), alone ? nullptr : make_mpi_transport(comm)};
}

}  // namespace ringsplat

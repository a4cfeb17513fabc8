#pragma once
#include <mpi.h>

#include <memory>
#include <optional>

#include "net/collectives.hpp"
#include "net/transport.hpp"

namespace ringsplat {

/// Throws RunError with the call's name, MPI's own words and the rank unless `code` is MPI_SUCCESS.
void checked(int code, const char* call);

/// Takes a message without a body that has come from `source`, which may be MPI_ANY_SOURCE: who sent it.
std::optional<int> take_signal(MPI_Comm comm, int source, int tag);

/// A duplicate of a communicator that returns errors instead of ending the job; freed with its owner, unless
/// MPI is already finalised.
class OwnedComm {
 public:
  explicit OwnedComm(MPI_Comm original);
  ~OwnedComm();
  OwnedComm(const OwnedComm&) = delete;
  OwnedComm& operator=(const OwnedComm&) = delete;
  MPI_Comm get() const { return comm_; }
  int rank() const { return rank_; }
  int ranks() const { return ranks_; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, ranks_ = 1;
};

/// Largest number of bytes in one MPI message; longer ones go in parts, since counts are `int`.
inline constexpr std::size_t largest_mpi_part = std::size_t{1} << 30;

/// Both duplicate `comm` (a collective call) and return errors as exceptions (RunError). All ranks
/// must give the same `largest_part` (at least a header's size); tests use small ones. Simulated ranks have a
/// transport of their own (simulate/smpi).
std::unique_ptr<Transport> make_mpi_transport(MPI_Comm comm, std::size_t largest_part = largest_mpi_part);
std::unique_ptr<Collectives> make_mpi_collectives(MPI_Comm comm, std::size_t largest_part = largest_mpi_part);

}  // namespace ringsplat

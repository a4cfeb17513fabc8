#pragma once
#include <mpi.h>

namespace ringsplat {

/// Throws RunError with the call's name, MPI's own words and the rank unless `code` is MPI_SUCCESS.
void checked(int code, const char* call);

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

}  // namespace ringsplat

#pragma once
#include <memory>
#include <string>
#include <vector>

#include "net/collectives.hpp"
#include "net/transport.hpp"
#include "ringsplat/net/processes.hpp"

/// Communicators of other languages, without mpi.h.
namespace ringsplat {

/// Owns MPI's lifetime and hides mpi.h from its users. The constructor initialises MPI (one thread calls it),
/// the destructor finalises it. In a build without MPI (room `alone`) the constructor throws InputError, and
/// launched() is false for a launcher's only process.
class MpiSession {
 public:
  MpiSession(int& argc, char**& argv);
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;

  /// All ranks call both, in the same order.
  std::unique_ptr<Transport> make_transport();
  std::unique_ptr<Collectives> make_collectives();
  /// Exchanges one text a rank, cut at 127 bytes; returns them by rank. All ranks call it before anything
  /// else. Its message has the same form in every build, so that ranks of different builds can detect each
  /// other.
  std::vector<std::string> introductions(const std::string& mine) const;
  /// Ends the job on all ranks.
  [[noreturn]] static void abort(int exit_code);

  /// True when a launcher (mpirun, srun, smpirun …) started this process.
  static bool launched();
  /// MPI's name and version, as "Open MPI v4.1.4"; empty in a build without it.
  static std::string library();
};

/// Connects the processes of a communicator by its number in Fortran (MPI_Comm_c2f), as connected() does
/// (ringsplat/mpi/communicator.hpp). Throws InputError in a build without MPI.
Processes connected_by_number(int communicator);

}  // namespace ringsplat

#include "mpi/session.hpp"

#include <cstdlib>

#include "net/launcher.hpp"
#include "ringsplat/base/error.hpp"

/// A build without MPI: the same class, for a process that is alone.
namespace ringsplat {

/// There is nothing that it could start.
MpiSession::MpiSession(int&, char**&) {
  const std::string rebuild = "build it with -DRINGSPLAT_WITH_MPI=ON";
  if (launched())
    throw InputError(
        "this build has no MPI, but a launcher started it: each process would draw the whole picture",
        rebuild + ", or start it without the launcher");
  throw InputError("--transport mpi: this build has no MPI", rebuild + ", or leave the option out");
}

MpiSession::~MpiSession() = default;

std::unique_ptr<Transport> MpiSession::make_transport() { return nullptr; }
std::unique_ptr<Collectives> MpiSession::make_collectives() { return std::make_unique<SoloCollectives>(); }
std::vector<std::string> MpiSession::introductions(const std::string& mine) const { return {mine}; }
void MpiSession::abort(int exit_code) { std::_Exit(exit_code); }

bool MpiSession::launched() { return started_by_launcher() && launched_processes() != 1; }

std::string MpiSession::library() { return {}; }

Processes connected_by_number(int) {
  throw InputError("this build has no MPI, so it has no communicators",
                   "build it with -DRINGSPLAT_WITH_MPI=ON, or open a session of this process alone");
}

}  // namespace ringsplat

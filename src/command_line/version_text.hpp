#pragma once
#include <string>

namespace ringsplat::app {

/// What --version prints: the version, and which libraries this build has and which were left out. `mpi`
/// names the library of the ranks; empty: there is none.
std::string version_text(const std::string& mpi);

}  // namespace ringsplat::app

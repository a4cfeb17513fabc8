#pragma once
#include <string>
#include <vector>

#include "command_line/subcommands.hpp"
#include "ringsplat/base/fact.hpp"

namespace ringsplat::app {

struct CommandLine {
  Command command;
  bool verbose = false;
  Facts options;                   ///< what the user said (settled_options)
  std::vector<std::string> notes;  ///< what the user should know of it, however it ends
  std::string error;               ///< one line with a hint, or empty
};

/// Reads the command line and the --config file it names. Does not throw: a rank cannot report an error
/// before it knows whether it is rank 0. `mpi` names the library of the ranks, for --version.
CommandLine parse_command_line(int argc, const char* const* argv, const std::string& mpi = {});

}  // namespace ringsplat::app

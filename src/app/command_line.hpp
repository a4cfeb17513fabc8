#pragma once
#include <string>
#include <variant>

#include "app/reference_options.hpp"

namespace ringsplat::app {

/// Print this on stdout and be done (--help, --version).
struct Say {
  std::string text;
};

struct CommandLine {
  /// What to do; nothing when the command line was wrong.
  std::variant<std::monostate, Say, RenderOptions, InfoOptions, CompareOptions, SynthOptions,
               ReferenceOptions, StudyOptions>
      command;
  bool verbose = false;
  Facts options;      ///< what was said (settled_options)
  std::string error;  ///< one line with a hint, or empty
};

/// Reads the command line and the --config file it names. Does not throw: a rank says what is wrong only when
/// it knows whether it is the one to speak.
CommandLine parse_command_line(int argc, const char* const* argv);

}  // namespace ringsplat::app

#pragma once

namespace ringsplat::app {

/// What is said of the program as a whole, in --help and in the manual page.
struct ProgramTexts {
  const char* summary;      ///< begins with the program's name
  const char* description;  ///< goes on from there
  const char* examples;     ///< command lines, indented
  const char* config;       ///< of --config, with {} for a line of such a file
  const char* exit_codes;
};

}  // namespace ringsplat::app

#pragma once

namespace ringsplat::app {

/// Texts about the program as a whole, for --help and the manual page.
struct ProgramTexts {
  const char* summary;      ///< begins with the program's name
  const char* description;  ///< continues the summary
  const char* examples;     ///< command lines, indented
  const char* config;       ///< help of --config, with {} for a line of such a file
  const char* exit_codes;
};

}  // namespace ringsplat::app

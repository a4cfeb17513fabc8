#pragma once
#include <memory>
#include <span>
#include <string>

#include "command_line/subcommands.hpp"

namespace CLI {
class FormatterBase;
}

/// What the program says of itself.
namespace ringsplat::app {

/// Texts about the program as a whole, for --help and the manual page.
struct ProgramTexts {
  const char* summary;      ///< begins with the program's name
  const char* description;  ///< continues the summary
  const char* examples;     ///< command lines, indented
  const char* config;       ///< help of --config, with {} for a line of such a file
  const char* exit_codes;
};

/// Writes --help and --help-all. Of a subcommand that names everyday options --help shows these alone, in few
/// words, so that they fit one screen.
std::shared_ptr<CLI::FormatterBase> help_formatter();

/// The manual page, section 1, as roff for man(7): all options of the program and its subcommands, and the
/// rules between them (contradictions.hpp).
std::string man_page(const OptionList& program, std::span<const BoundSubcommand> subcommands,
                     const ProgramTexts& texts);

/// The shells that completion_script() knows, as --help shows them.
inline constexpr const char* completion_shells = "bash|zsh|fish";

/// A script with which that shell asks the program how a command line may go on. Throws InputError for a
/// shell that it does not know.
std::string completion_script(const std::string& shell);

/// How a command line may go on, of which `words` are the ones behind the program's name up to the cursor: a
/// line for each word that may stand in the last one's place, with what it means behind a tab. A line
/// ":files" or ":folders" stands for those that the shell finds.
std::string completions(const OptionList& program, std::span<const BoundSubcommand> subcommands, Words words);

}  // namespace ringsplat::app

#pragma once
#include <span>
#include <string>

#include "command_line/subcommands.hpp"

namespace ringsplat::app {

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

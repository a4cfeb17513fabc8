#pragma once
#include <span>
#include <string>

#include "command_line/program_texts.hpp"
#include "command_line/subcommands.hpp"

namespace ringsplat::app {

/// The manual page, section 1, as roff for man(7): all options of the program and its subcommands, and the
/// rules between them (contradictions.hpp).
std::string man_page(const OptionList& program, std::span<const BoundSubcommand> subcommands,
                     const ProgramTexts& texts);

}  // namespace ringsplat::app

#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "options/program_texts.hpp"

namespace ringsplat::app {

/// The manual page, section 1, as roff for man(7): all options of `program` and its subcommands, and the
/// rules between them (contradictions.hpp).
std::string man_page(const CLI::App& program, const ProgramTexts& texts);

}  // namespace ringsplat::app

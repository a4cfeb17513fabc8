#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "app/program_texts.hpp"

namespace ringsplat::app {

/// The manual page, section 1, as roff for man(7): all options of `program` and of its subcommands, and what
/// they have to do with each other (contradictions.hpp).
std::string man_page(const CLI::App& program, const ProgramTexts& texts);

}  // namespace ringsplat::app

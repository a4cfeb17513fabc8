#pragma once
#include "options/option_list.hpp"
#include "ringsplat/base/fact.hpp"

namespace ringsplat::app {

/// The settings of a subcommand and of the program, option by option, whether from the command line, a
/// --config file or a default. All ranks of a job must have the same. Leaves out --config itself, since only
/// the file's content counts, and --verbose, which may differ between ranks.
Facts settled_options(const char* subcommand, const OptionList& options, const OptionList& program);

}  // namespace ringsplat::app

#pragma once
#include <CLI/CLI.hpp>

#include "ringsplat/base/fact.hpp"

namespace ringsplat::app {

/// A parsed program's settings, option by option, whether from the command line, a --config file or a
/// default. All ranks of a job must have the same. Leaves out --config itself, since only the file's content
/// counts, and --verbose, which may differ between ranks.
Facts settled_options(const CLI::App& program);

}  // namespace ringsplat::app

#pragma once
#include <CLI/CLI.hpp>

#include "ringsplat/base/fact.hpp"

namespace ringsplat::app {

/// What a parsed program was told, option by option, wherever each came from: the command line, a --config
/// file, or its default. Ranks of one job must be told the same. Left out are --config itself, since only
/// what is in the file counts, and --verbose, which a rank may have for itself.
Facts settled_options(const CLI::App& program);

}  // namespace ringsplat::app

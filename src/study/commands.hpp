#pragma once
#include "options/options.hpp"
#include "ringsplat/base/error.hpp"

/// One function a subcommand, on one process. All throw InputError and RunError.
namespace ringsplat::app {

ExitCode run_compare(const CompareOptions& options);
ExitCode run_study(const StudyOptions& options);

}  // namespace ringsplat::app

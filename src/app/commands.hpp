#pragma once
#include "options/options.hpp"
#include "program/launch.hpp"
#include "ringsplat/base/error.hpp"

/// One function a subcommand. All throw InputError and RunError.
namespace ringsplat::app {

// All ranks call these.
ExitCode run(const RenderOptions& options, Launch& launch);
ExitCode run(const ServeOptions& options, Launch& launch);
ExitCode run(const PyramidOptions& options, Launch& launch);
// The others run on one process.
ExitCode run(const InfoOptions& options);
ExitCode run(const CompareOptions& options);
ExitCode run(const SynthOptions& options);
ExitCode run(const ReferenceOptions& options);

/// The whole program: reads the command line, starts MPI when a launcher asks for it, runs the subcommand and
/// reports errors. For wrong input rank 0 prints the message and all ranks return 2; a rank that fails prints
/// its message and ends the job with 3. Returns the process's exit code.
int run_program(int argc, char** argv);

}  // namespace ringsplat::app

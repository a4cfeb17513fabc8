#pragma once

namespace ringsplat::app {

/// The whole program: reads the command line, starts MPI when a launcher asks for it, runs the subcommand and
/// reports errors. For wrong input rank 0 prints the message and all ranks return 2; a rank that fails prints
/// its message and ends the job with 3. Returns the process's exit code.
int run_program(int argc, char** argv);

}  // namespace ringsplat::app

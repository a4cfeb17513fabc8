#pragma once

namespace ringsplat::app {

/// The whole program: reads the command line, starts MPI when a launcher asks for it, runs the subcommand,
/// and is the one way out: rank 0 says what was wrong with the input, and all ranks return 2; a rank that
/// fails says so and ends the job with 3. Returns the process's exit code.
int run_program(int argc, char** argv);

}  // namespace ringsplat::app

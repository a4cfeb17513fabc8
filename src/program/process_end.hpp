#pragma once

namespace ringsplat::app {

/// Makes a file over the file size limit a write error, not a signal.
void ignore_file_size_signal();

/// Has what ends the program where nobody can catch it, such as a thread without memory, end it with
/// run_failed and a line when memory is what was lacking.
void prepare_for_lack_of_memory();

}  // namespace ringsplat::app

#pragma once

namespace ringsplat::app {

/// A signal that ends the process (hang-up, interrupt, quit, termination, processor time, a closed pipe)
/// removes its unfinished files first; one that was ignored before stays so. A file that grows over the limit
/// of files' sizes is an error of writing, not a signal.
void prepare_for_signals();

/// `code`, or that of a failed run, with a message, when not all that was printed could be.
int exit_code_after_printing(int code);

}  // namespace ringsplat::app

#pragma once

namespace ringsplat::app {

/// A signal that ends the process (hang-up, interrupt, quit, termination, processor time, a closed pipe)
/// removes its unfinished files first; one that was ignored before stays so. A file that grows over the limit
/// of files' sizes is an error of writing, not a signal.
void prepare_for_signals();

}  // namespace ringsplat::app

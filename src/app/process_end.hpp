#pragma once

namespace ringsplat::app {

/// Makes signals that end the process (hang-up, interrupt, quit, termination, processor time, a closed pipe)
/// remove its unfinished files first; ignored signals stay ignored. A file over the file size limit becomes a
/// write error, not a signal.
void prepare_for_signals();

}  // namespace ringsplat::app

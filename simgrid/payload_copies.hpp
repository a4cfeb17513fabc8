#pragma once

namespace ringsplat::simgrid_platform {

/// Lets SimGrid copy no more than the first bytes of payloads that only count (Header::counted), whose true size it still
/// charges. Without that, a large volume's frame moves hundreds of gigabytes through this machine's memory.
void copy_only_what_counts();

}  // namespace ringsplat::simgrid_platform

#pragma once
#include <cstddef>
#include <functional>

namespace ringsplat::simgrid_platform {

/// Makes SimGrid copy only the first bytes of payloads that only count (counted_magic); it still charges
/// their true size. Otherwise a large volume's frame moves hundreds of gigabytes through this machine's
/// memory.
void copy_only_what_counts();

/// Calls `callback` with a payload's size when it arrives: when SimGrid copies it to its receiver.
void on_payload_copied(std::function<void(std::size_t bytes)> callback);

}  // namespace ringsplat::simgrid_platform

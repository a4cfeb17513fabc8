#pragma once
#include <cstddef>
#include <functional>

namespace ringsplat::simgrid_platform {

/// Lets SimGrid copy no more than the first bytes of payloads that only count (Header::counted), whose true
/// size it still charges. Without that, a large volume's frame moves hundreds of gigabytes through this
/// machine's memory.
void copy_only_what_counts();

/// Has `callback` called with a payload's bytes when SimGrid copies it to its receiver, which is when it has
/// arrived.
void on_payload_copied(std::function<void(std::size_t bytes)> callback);

}  // namespace ringsplat::simgrid_platform

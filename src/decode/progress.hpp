#pragma once
#include <cstdint>

namespace ringsplat::decode {

/// Gives this process ten more seconds of the processor's time and two more gigabytes of memory, and what
/// reading `bytes` may need of both. When the time is over the system ends it; more memory is not there.
/// Called whenever something was read, so that what comes to no end is ended, and nothing else.
void progress(std::uint64_t bytes = 0);

}  // namespace ringsplat::decode

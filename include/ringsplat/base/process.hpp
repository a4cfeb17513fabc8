#pragma once
#include <cstdint>

namespace ringsplat {

/// Peak resident memory of this process so far, in bytes (Linux: VmHWM).
std::uint64_t peak_memory_bytes();

/// Makes this thread treat denormal floats as zero, as operands and as results, where the
/// processor can: their cost is hundreds of cycles and their weight is nothing.
void flush_denormals();

}  // namespace ringsplat

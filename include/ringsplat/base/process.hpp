#pragma once
#include <cstdint>
#include <string>

namespace ringsplat {

/// Peak resident memory of this process so far, in bytes (Linux: VmHWM).
std::uint64_t peak_memory_bytes();

/// Names the clock behind now_seconds(): processes for which it is equal read the same one (Linux: the
/// machine's boot). Empty when that cannot be said.
std::string clock_identity();

/// Cores that this process may run on (Linux: its affinity mask, which launchers narrow), at least 1.
int allowed_cores();

/// Opens /dev/null in place of stdin, stdout and stderr where they are closed: else the next file that is
/// opened would take their place, and be written what is printed.
void keep_standard_descriptors();

/// Makes this thread treat denormal floats as zero, as operands and as results, where the
/// processor can: their cost is hundreds of cycles and their weight is nothing.
void flush_denormals();

}  // namespace ringsplat

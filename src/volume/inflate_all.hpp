#pragma once
#include <cstdint>

#include "volume/input_file.hpp"
#include "volume/memory_file.hpp"

namespace ringsplat::detail {

/// Decodes a deflate stream without a header of its own (RFC 1951) from a byte of the file on. Throws
/// InputError when it is damaged or ends before.
void inflate_all(const InputFile& file, std::uint64_t offset, MemoryFile& out);

}  // namespace ringsplat::detail

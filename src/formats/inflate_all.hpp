#pragma once
#include <cstdint>

#include "base/input_file.hpp"
#include "base/memory_file.hpp"

namespace ringsplat::detail {

/// Decodes a raw deflate stream (RFC 1951) that begins at byte `offset` of the file. Throws InputError when
/// it is damaged or ends too early.
void inflate_all(const InputFile& file, std::uint64_t offset, MemoryFile& out);

}  // namespace ringsplat::detail

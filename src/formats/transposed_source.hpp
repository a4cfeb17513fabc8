#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>

#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// A raw volume whose file has z fastest and x slowest. Holds the slices that were read last, as many as
/// fit into `most_held` bytes but at least one. Not concurrent: every layer needs bytes from the whole file.
/// Throws InputError when the file is too short.
std::unique_ptr<VolumeSource> transposed_source(const Grid& grid, const std::filesystem::path& file,
                                                std::uint64_t offset, bool big_endian,
                                                std::uint64_t most_held = 64 << 20);

}  // namespace ringsplat::detail

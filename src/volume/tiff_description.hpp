#pragma once
#include <cstdint>
#include <filesystem>

namespace ringsplat::detail {

/// Throws InputError unless the file's `pages` are the slices of one channel at one time, all in this file.
/// Pages may be channels or time points, too; ImageJ ("ImageJ=1.53...") and OME-TIFF (OME-XML) say so in the
/// ImageDescription. A file without such a description passes.
void require_one_stack(const std::filesystem::path& path, std::uint64_t pages);

/// Warns when the file gives a voxel size: it is not used.
void warn_of_voxel_size(const std::filesystem::path& path);

}  // namespace ringsplat::detail

#pragma once
#include <cstdint>
#include <filesystem>

namespace ringsplat::detail {

/// Reads what ImageJ ("ImageJ=1.53...") and OME-TIFF (OME-XML) write into a file's ImageDescription: pages
/// may be channels and time points too, and then are no stack of slices. Throws InputError unless the file's
/// `pages` are the slices of one channel at one time, all in this file. A file that says nothing passes.
void require_one_stack(const std::filesystem::path& path, std::uint64_t pages);

/// Warns when the file says a size of its voxels, which is not read.
void warn_of_voxel_size(const std::filesystem::path& path);

}  // namespace ringsplat::detail

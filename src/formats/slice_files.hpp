#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// A volume whose z slices lie in several files, equally many in each, uncompressed.
struct SliceFiles {
  std::vector<std::filesystem::path> files;  ///< in the slices' order
  std::int64_t header_size = 0;              ///< bytes before a file's voxels; -1: they are its last bytes
  bool big_endian = false;
};

/// Reads each slice from its own file, concurrently. Throws InputError naming the first file that is missing
/// or too short. grid.dims.z must be a multiple of the number of files.
std::unique_ptr<VolumeSource> slice_files_source(const Grid& grid, SliceFiles slices);

}  // namespace ringsplat::detail

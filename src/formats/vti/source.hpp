#pragma once
#include <filesystem>
#include <memory>

#include "formats/vti/header.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// A binary array's voxels: uncompressed appended ones are read by position (concurrent), others decoded in
/// order, a block at a time. `grid`: interleaved components. Throws InputError when the array's own sizes are
/// not the grid's, or the file cannot hold them.
std::unique_ptr<VolumeSource> vti_source(const Grid& grid, const std::filesystem::path& path,
                                         const VtiHeader& header, const VtiArray& array);

}  // namespace ringsplat::detail

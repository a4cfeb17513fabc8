#pragma once
#include <filesystem>
#include <memory>

#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// Reads the usual NRRD without NrrdIO, for builds without ITK: one volume of at most three axes, raw, gzip
/// or ASCII, in its own file or in one other. The same grid, notes and voxels as open_nrrd() with ITK. Throws
/// InputError for damaged headers, and for all else with the build option that reads it.
std::unique_ptr<VolumeSource> open_plain_nrrd(const std::filesystem::path& path);

}  // namespace ringsplat::detail

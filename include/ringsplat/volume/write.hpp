#pragma once
#include <filesystem>

#include "ringsplat/volume/source.hpp"

namespace ringsplat {

/// Writes a volume slice by slice: .nrrd (gzip when `compress`), .nhdr + .raw, .mhd, or .raw (its
/// name then gets `_XxYxZ_type` when it lacks it). Writes beside and renames; throws InputError for
/// an unknown ending or a folder that cannot be written. Returns the path written.
std::filesystem::path write_volume(VolumeSource& source, const std::filesystem::path& path,
                                   bool compress = true);

}  // namespace ringsplat

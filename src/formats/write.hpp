#pragma once
#include <filesystem>

#include "ringsplat/volume/source.hpp"

namespace ringsplat {

/// Writes a volume slice by slice: .nrrd (gzip when `compress`), .nhdr + .raw, .mhd, or .raw (its
/// name then gets `_XxYxZ_type` when it lacks it). Throws InputError for an unknown ending or a folder that
/// cannot be written, RunError when the disk is full or fails: what was there stays until all is on the disk.
/// Returns the path written. `world`: as NRRD says it.
std::filesystem::path write_volume(VolumeSource& source, const std::filesystem::path& path,
                                   bool compress = true, World world = World::patient);

}  // namespace ringsplat

#pragma once
#include <filesystem>
#include <memory>

#include "formats/decode/messages.hpp"

namespace ringsplat::detail {

/// A volume that ringsplat-decode reads, or whose voxels it finds as they are in the file, where this process
/// then reads them itself. Throws InputError as the format does, also when its library crashes, takes too
/// much time or memory.
std::unique_ptr<VolumeSource> decoded_source(DecodedFormat format, const std::filesystem::path& path,
                                             const VolumeChoice& choice);

}  // namespace ringsplat::detail

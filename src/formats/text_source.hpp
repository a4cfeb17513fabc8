#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>

#include "formats/limits.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// A volume written as numbers with blanks or commas between them, from byte `offset` of the file on, before
/// byte `end`, x fastest. The first read keeps the whole volume; not concurrent. Throws InputError for fewer
/// words than voxels; reading throws it for a word that is no number of the grid's type.
std::unique_ptr<VolumeSource> text_source(const Grid& grid, const std::filesystem::path& file,
                                          std::uint64_t offset, std::uint64_t end = file_end);

}  // namespace ringsplat::detail

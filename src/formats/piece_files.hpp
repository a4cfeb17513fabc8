#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// Makes the source of one file, whose voxels are the grid's.
using OpenPiece = std::function<std::unique_ptr<VolumeSource>(const Grid&, const std::filesystem::path&)>;

/// A volume that several files hold behind each other, equally many voxels in each: whole slices, whole rows
/// of one slice, or a part of a row. Concurrent when its files are. Opens every file, so that one which is
/// missing or too short is an error at once.
std::unique_ptr<VolumeSource> piece_files_source(const Grid& grid, std::vector<std::filesystem::path> files,
                                                 OpenPiece open);

}  // namespace ringsplat::detail

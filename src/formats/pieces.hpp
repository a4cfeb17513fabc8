#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// A box of a volume's voxels, which a source of its own holds, and maybe others around them.
struct VolumePiece {
  std::filesystem::path file;
  glm::ivec3 first{0}, end{0};  ///< of the box, which lies in the volume and is not empty
  glm::ivec3 from{0};           ///< where the source's first voxel lies there
  std::function<std::unique_ptr<VolumeSource>()> open = {};
};

/// The volume that pieces fill. All are opened once, so that a missing or damaged one is an InputError at
/// once, and so are pieces that overlap or leave gaps; later only those that a slice goes through. `where`:
/// for messages.
std::unique_ptr<VolumeSource> pieced_source(const Grid& grid, std::vector<VolumePiece> pieces,
                                            const std::string& where);

}  // namespace ringsplat::detail

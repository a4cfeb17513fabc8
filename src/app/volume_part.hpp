#pragma once
#include "options/options.hpp"

namespace ringsplat::app {

/// Chooses a part of what `volume` does.
inline VolumeOptions part_of(VolumeOptions volume, const VoxelBox& part) {
  volume.choice.crop = [before = volume.choice.crop, part](const Grid& whole) {
    const glm::ivec3 first = before ? before(whole).first : glm::ivec3(0);
    return VoxelBox{part.first + first, part.end + first};
  };
  return volume;
}

}  // namespace ringsplat::app

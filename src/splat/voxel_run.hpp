#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "splat/splat.hpp"

namespace ringsplat {

/// The visible voxels among 64 neighbouring columns of a slice's row. Every rank knows the view, from which
/// their positions follow, so only a bit for each voxel, its colour and its opacity travel.
struct VoxelRun {
  std::uint32_t row, first;  ///< first: column, a multiple of 64
  std::uint64_t mask;        ///< bit i: the voxel of column first + i; never 0
};

/// Heads one region's voxels of a slice: `blocks` VoxelRun, then `voxels` colours.
struct BlockGroup {
  std::int32_t region;
  std::uint32_t blocks, voxels;
};

/// A voxel as it travels: straight linear colour, and the opacity as a float, corrected and not yet weighted.
struct PackedVoxel {
  std::uint16_t opacity[2];
  std::uint16_t rgb[3];
};
static_assert(sizeof(PackedVoxel) == 10);

/// A region's blocks as they travel: VoxelRuns at any alignment, and the voxels of all blocks in order.
struct VoxelRuns {
  const std::byte* blocks;
  std::uint32_t count;
  const PackedVoxel* voxels;
};

struct DrawnBlocks {
  std::uint32_t blocks = 0;  ///< gone through
  DrawCounts counts;         ///< of their voxels: drawn are those with a weight above zero in the region
};

/// Packs `count` voxels, given as (red, green, blue, opacity), straight and within [0, 1]. Colours are
/// rounded to nearest.
inline void pack(const float* rgba, std::size_t count, PackedVoxel* voxels) {
  // Words are computed together, which compilers vectorise.
  constexpr std::size_t together = 64;
  std::array<std::int32_t, 4 * together> words;
  for (; count > 0;) {
    const std::size_t some = std::min(count, together);
    for (std::size_t i = 0; i < 4 * some; ++i)
      words[i] = std::int32_t(rgba[i] * 65535.0F + 0.5F);  // NOLINT(bugprone-incorrect-roundings)
    for (std::size_t k = 0; k < some; ++k) {
      std::memcpy(voxels[k].opacity, rgba + 4 * k + 3, sizeof voxels[k].opacity);
      for (std::size_t c = 0; c < 3; ++c) voxels[k].rgb[c] = std::uint16_t(words[4 * k + c]);
    }
    rgba += 4 * some;
    voxels += some;
    count -= some;
  }
}

inline VoxelColour unpack(const PackedVoxel& in) {
  VoxelColour out{in.rgb[0], in.rgb[1], in.rgb[2], 0};
  std::memcpy(&out.opacity, in.opacity, sizeof out.opacity);
  return out;
}

}  // namespace ringsplat

#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/half.hpp"
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

/// Voxels as they travel: straight linear colour, and the opacity, corrected and not yet weighted. This one
/// has the numbers that a Splat has, so it draws the same bits.
struct FloatVoxel {
  std::uint16_t opacity[2];
  std::uint16_t rgb[3];
};
static_assert(sizeof(FloatVoxel) == 10);
struct HalfVoxel {  ///< IEEE 754 binary16
  std::uint16_t rgba[4];
};
struct ByteVoxel {  ///< 255 = 1
  std::uint8_t rgba[4];
};

/// A region's blocks as they travel: VoxelRuns at any alignment, and the voxels of all blocks in order.
template <class Voxel>
struct VoxelRuns {
  const std::byte* blocks;
  std::uint32_t count;
  const Voxel* voxels;
};

/// Packs `count` voxels, given as (red, green, blue, opacity), straight and within [0, 1]. FloatVoxel's
/// colours are rounded as by quantise_colour, halves to nearest even, bytes to nearest.
void pack(const float* rgba, std::size_t count, FloatVoxel* voxels);
void pack(const float* rgba, std::size_t count, HalfVoxel* voxels);
void pack(const float* rgba, std::size_t count, ByteVoxel* voxels);

inline VoxelColour unpack(const FloatVoxel& in) {
  VoxelColour out{in.rgb[0], in.rgb[1], in.rgb[2], 0};
  std::memcpy(&out.opacity, in.opacity, sizeof out.opacity);
  return out;
}
inline VoxelColour unpack(const HalfVoxel& in) {
  return {quantise_colour(from_half(in.rgba[0])), quantise_colour(from_half(in.rgba[1])),
          quantise_colour(from_half(in.rgba[2])), from_half(in.rgba[3])};
}
inline VoxelColour unpack(const ByteVoxel& in) {
  const auto widen = [](std::uint8_t value) { return static_cast<std::uint16_t>(257 * value); };
  return {widen(in.rgba[0]), widen(in.rgba[1]), widen(in.rgba[2]), static_cast<float>(in.rgba[3]) / 255.0F};
}

}  // namespace ringsplat

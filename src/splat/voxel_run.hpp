#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <glm/packing.hpp>

#include "splat/encode.hpp"

namespace ringsplat {

/// Visible voxels of a slice's row, among 64 neighbouring columns. Their positions follow from the view,
/// which every rank knows, so a bit each says where they are and only their colours and opacities travel.
struct VoxelBlock {
  std::uint32_t row, first;  ///< first: column, a multiple of 64
  std::uint64_t mask;        ///< bit i: the voxel of column first + i; never 0
};

/// Heads one region's voxels of a slice: `blocks` VoxelBlock, then `voxels` colours.
struct BlockGroup {
  std::int32_t region;
  std::uint32_t blocks, voxels;
};

/// A voxel's straight linear colour and its opacity, corrected and not yet weighted, as they travel.
struct FloatVoxel {  ///< what a Splat carries of them, so it draws the same bits
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

/// A region's blocks as they travel: VoxelBlock at any alignment, and the voxels of all in their order.
template <class Voxel>
struct VoxelBlocks {
  const std::byte* blocks;
  std::uint32_t count;
  const Voxel* voxels;
};

/// Makes them of `count` voxels' (red, green, blue, opacity), straight and within [0, 1], into `count`
/// places. The same bits at every vector width: FloatVoxel's colours by quantise_colour, halves rounded to
/// nearest even, bytes to nearest.
void pack(const float* rgba, std::size_t count, FloatVoxel* voxels);
void pack(const float* rgba, std::size_t count, HalfVoxel* voxels);
void pack(const float* rgba, std::size_t count, ByteVoxel* voxels);

struct VoxelColour {
  std::uint16_t red, green, blue;  ///< 65535 = 1
  float opacity;
};
inline VoxelColour unpack(const FloatVoxel& in) {
  VoxelColour out{in.rgb[0], in.rgb[1], in.rgb[2], 0};
  std::memcpy(&out.opacity, in.opacity, sizeof out.opacity);
  return out;
}
inline VoxelColour unpack(const HalfVoxel& in) {
  std::uint64_t packed;
  std::memcpy(&packed, in.rgba, sizeof packed);
  const glm::vec4 rgba = glm::unpackHalf4x16(packed);
  return {quantise_colour(rgba.r), quantise_colour(rgba.g), quantise_colour(rgba.b), rgba.a};
}
inline VoxelColour unpack(const ByteVoxel& in) {
  const auto widen = [](std::uint8_t value) { return static_cast<std::uint16_t>(257 * value); };
  return {widen(in.rgba[0]), widen(in.rgba[1]), widen(in.rgba[2]), static_cast<float>(in.rgba[3]) / 255.0F};
}

}  // namespace ringsplat

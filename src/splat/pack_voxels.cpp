#include <algorithm>
#include <array>
#include <bit>

#include "splat/voxel_run.hpp"

namespace ringsplat {
namespace {

/// Rounds 0 and numbers from 2⁻¹²⁶ to 65504 to nearest even (Giesen 2012, "Float->half variants").
std::uint16_t to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  // The sum has the half's last place, so that adding rounds.
  const std::uint32_t subnormal =
      std::bit_cast<std::uint32_t>(value + 0.5F) - std::bit_cast<std::uint32_t>(0.5F);
  const std::uint32_t normal = (bits - (std::uint32_t{127 - 15} << 23) + 0xfff + (bits >> 13 & 1)) >> 13;
  const std::uint32_t is_subnormal = bits < std::bit_cast<std::uint32_t>(0x1p-14F) ? ~0U : 0U;
  return static_cast<std::uint16_t>((subnormal & is_subnormal) | (normal & ~is_subnormal));
}

}  // namespace

void pack(const float* rgba, std::size_t count, FloatVoxel* voxels) {
  // Words are computed together, which compilers vectorise.
  constexpr std::size_t together = 64;
  std::array<std::int32_t, 4 * together> words;
  for (; count > 0;) {
    const std::size_t some = std::min(count, together);
    for (std::size_t i = 0; i < 4 * some; ++i)
      words[i] =
          static_cast<std::int32_t>(rgba[i] * 65535.0F + 0.5F);  // NOLINT(bugprone-incorrect-roundings)
    for (std::size_t k = 0; k < some; ++k) {
      std::memcpy(voxels[k].opacity, rgba + 4 * k + 3, sizeof voxels[k].opacity);
      for (std::size_t c = 0; c < 3; ++c) voxels[k].rgb[c] = static_cast<std::uint16_t>(words[4 * k + c]);
    }
    rgba += 4 * some;
    voxels += some;
    count -= some;
  }
}

void pack(const float* rgba, std::size_t count, HalfVoxel* voxels) {
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t c = 0; c < 4; ++c) voxels[k].rgba[c] = to_half(rgba[4 * k + c]);
}

void pack(const float* rgba, std::size_t count, ByteVoxel* voxels) {
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t c = 0; c < 4; ++c)
      voxels[k].rgba[c] = static_cast<std::uint8_t>(  // NOLINTNEXTLINE(bugprone-incorrect-roundings)
          static_cast<std::int32_t>(rgba[4 * k + c] * 255.0F + 0.5F));
}

}  // namespace ringsplat

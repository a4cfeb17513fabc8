#pragma once
#include <bit>
#include <cstdint>

/// IEEE 754 binary16 of numbers that are not negative.
namespace ringsplat {

/// Rounds 0, but not -0, and numbers from 2⁻¹²⁶ to 65504 to nearest even (Giesen 2012, "Float->half variants").
inline std::uint16_t to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  // The sum has the half's last place, so that adding rounds.
  const std::uint32_t subnormal =
      std::bit_cast<std::uint32_t>(value + 0.5F) - std::bit_cast<std::uint32_t>(0.5F);
  const std::uint32_t normal = (bits - (std::uint32_t{127 - 15} << 23) + 0xfff + (bits >> 13 & 1)) >> 13;
  const std::uint32_t is_subnormal = bits < std::bit_cast<std::uint32_t>(0x1p-14F) ? ~0U : 0U;
  return static_cast<std::uint16_t>((subnormal & is_subnormal) | (normal & ~is_subnormal));
}

/// Of a finite half; others give some finite number.
inline float from_half(std::uint16_t half) {
  constexpr std::uint32_t smallest_normal = 1U << 10, bias = 127 - 15;
  if (half < smallest_normal) return static_cast<float>(half) * 0x1p-24F;
  return std::bit_cast<float>((std::uint32_t{half} << 13 & 0x0fffffff) + (bias << 23));
}

}  // namespace ringsplat

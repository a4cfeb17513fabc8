#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ringsplat {

/// Display values (0 to 1) to linear light and back (IEC 61966-2-1:1999), in single precision with
/// OpenImageIO's results.
inline float linear_of_srgb(float value) {
  return value <= 0.04045F ? value * (1.0F / 12.92F) : std::pow((value + 0.055F) * (1.0F / 1.055F), 2.4F);
}
inline float srgb_of_linear(float value) {
  return value <= 0.0031308F ? 12.92F * value : 1.055F * std::pow(value, 1.0F / 2.4F) - 0.055F;
}

/// A share as 8 bits, rounded to nearest. Not-a-number compares false and becomes 0.
inline std::uint8_t to_byte(float v) {
  return static_cast<std::uint8_t>(v > 0 ? std::min(v, 1.0F) * 255.0F + 0.5F : 0.0F);
}

}  // namespace ringsplat

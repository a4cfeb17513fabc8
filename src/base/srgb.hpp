#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

namespace ringsplat {

/// Display value to linear light and back, both 0..1 (IEC 61966-2-1:1999).
inline double srgb_to_linear(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
inline double linear_to_srgb(double v) {
  return v <= 0.0031308 ? v * 12.92 : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
}
/// In single precision with OpenImageIO's results.
inline float srgb_to_linear(float v) {
  return v <= 0.04045F ? v * (1.0F / 12.92F) : std::pow((v + 0.055F) * (1.0F / 1.055F), 2.4F);
}
inline float linear_to_srgb(float v) {
  return v <= 0.0031308F ? 12.92F * v : 1.055F * std::pow(v, 1.0F / 2.4F) - 0.055F;
}
inline glm::dvec3 srgb_to_linear(const glm::dvec3& c) {
  return {srgb_to_linear(c.x), srgb_to_linear(c.y), srgb_to_linear(c.z)};
}
inline glm::dvec3 linear_to_srgb(const glm::dvec3& c) {
  return {linear_to_srgb(c.x), linear_to_srgb(c.y), linear_to_srgb(c.z)};
}

/// A share as 8 bits, rounded to nearest. Not-a-number compares false and becomes 0.
inline std::uint8_t to_byte(float v) {
  return static_cast<std::uint8_t>(v > 0 ? std::min(v, 1.0F) * 255.0F + 0.5F : 0.0F);
}

/// 0xrrggbb as display (sRGB) values, 0 to 1.
inline glm::dvec3 colour_of(std::uint32_t rgb) {
  return {double(rgb >> 16 & 255) / 255, double(rgb >> 8 & 255) / 255, double(rgb & 255) / 255};
}

/// A colour's six hexadecimal digits as display values; nothing for other texts.
inline std::optional<glm::dvec3> hex_colour(std::string_view digits) {
  std::uint32_t rgb = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), rgb, 16);
  if (digits.size() != 6 || error != std::errc() || end != digits.data() + 6) return {};
  return colour_of(rgb);
}

}  // namespace ringsplat

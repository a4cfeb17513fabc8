#pragma once
#include <charconv>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

namespace ringsplat {

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

#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

/// Text, lines and bars to lay over a picture.
namespace ringsplat {

/// How much of each pixel of a rectangle is covered, 0 to 1, rows from the top.
struct Mask {
  int x = 0, y = 0, width = 0, height = 0;  ///< in the picture, whose pixels count from its upper left corner
  std::vector<float> coverage;
};

/// A rectangle of premultiplied display (sRGB) values, RGBA.
struct Patch {
  int x = 0, y = 0, width = 0, height = 0;
  std::vector<float> rgba;
};
using Overlay = std::vector<Patch>;  ///< the last one is on top

/// A line of UTF-8 in letters whose nominal height is `pixels`, in the font that RINGSPLAT_FONT names, or a
/// usual sans serif. Its baseline begins at (0, 0). Throws InputError when there is no font that can be used.
Mask text_mask(const std::string& text, int pixels);
/// A line `thickness` pixels wide between two places; pixel centres lie at integers + ½.
Mask line_mask(const glm::dvec2& from, const glm::dvec2& to, double thickness);

/// The mask in `ink`, above a halo in another colour that reaches so many pixels beyond it.
Patch inked(const Mask& mask, const glm::dvec3& ink, const glm::dvec3& halo, double halo_pixels);

/// Lays patches over a picture. The first takes display values of 8 bits with 3 channels, or 4 of which the
/// last is straight alpha; the second linear light, premultiplied when there are 4 channels.
void lay_over(const Overlay& overlay, int width, int height, int channels, std::span<std::uint8_t> display);
void lay_over(const Overlay& overlay, int width, int height, int channels, std::span<float> linear);

}  // namespace ringsplat

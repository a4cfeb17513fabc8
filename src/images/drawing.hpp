#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
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
  std::size_t place(int column, int row) const {
    return std::size_t(row) * std::size_t(width) + std::size_t(column);
  }
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

/// Text and lines for one picture, all in sizes that follow from its shorter side.
class Drawing {
 public:
  Drawing(int width, int height, bool dark_ink)
      : letter_(std::max(readable, static_cast<int>(std::lround(std::min(width, height) / 34.0)))),
        ink_(dark_ink ? 0.0 : 1.0) {}

  /// The nominal height of letters.
  double letter() const { return letter_; }
  glm::dvec3 ink() const { return ink_; }
  /// A text whose middle lies `across` (0: at its left end, 1: at its right one) and at the given height.
  void text(const std::string& text, const glm::dvec2& place, double across, double size = 1) {
    Mask mask = text_mask(text, static_cast<int>(std::lround(size * letter_)));
    mask.x = static_cast<int>(std::lround(place.x - across * mask.width));
    mask.y = static_cast<int>(std::lround(place.y - 0.5 * mask.height));
    add(mask, ink_);
  }
  /// `thickness`: in letters.
  void line(const glm::dvec2& from, const glm::dvec2& to, const glm::dvec3& ink, double thickness = 0.12) {
    add(line_mask(from, to, std::max(1.0, thickness * letter_)), ink);
  }

  Overlay drawn;

 private:
  void add(const Mask& mask, const glm::dvec3& ink) {
    drawn.push_back(inked(mask, ink, 1.0 - ink_, std::max(1.0, 0.1 * letter_)));
  }

  static constexpr int readable = 10;  ///< pixels, at least
  int letter_;
  glm::dvec3 ink_;
};

/// Lays patches over a picture. The first takes display values of 8 bits with 3 channels, or 4 of which the
/// last is straight alpha; the second linear light, premultiplied when there are 4 channels.
void lay_over(const Overlay& overlay, int width, int height, int channels, std::span<std::uint8_t> display);
void lay_over(const Overlay& overlay, int width, int height, int channels, std::span<float> linear);

}  // namespace ringsplat

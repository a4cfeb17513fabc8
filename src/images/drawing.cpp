#include "images/drawing.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>

#include "base/srgb.hpp"
#include "images/image_library.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

double distance_to_segment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
  const glm::dvec2 along = b - a;
  const double length2 = glm::dot(along, along);
  const double t = length2 > 0 ? std::clamp(glm::dot(p - a, along) / length2, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + t * along);
}

/// What a disc covers whose centre goes over all of the mask.
Mask grown(const Mask& mask, double radius) {
  const int r = static_cast<int>(std::ceil(radius));
  const Mask disc = line_mask(glm::dvec2(0.5), glm::dvec2(0.5), 2 * radius);
  Mask wide{mask.x - r, mask.y - r, mask.width + 2 * r, mask.height + 2 * r, {}};
  wide.coverage.resize(std::size_t(wide.width) * std::size_t(wide.height));
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const float covered = mask.coverage[mask.place(x, y)];
      if (covered <= 0) continue;
      for (int dy = -r; dy <= r; ++dy)
        for (int dx = -r; dx <= r; ++dx) {
          float& there = wide.coverage[wide.place(x + r + dx, y + r + dy)];
          there = std::max(there, covered * disc.coverage[disc.place(dx - disc.x, dy - disc.y)]);
        }
    }
  return wide;
}

/// Calls f(patch's values, pixel's number) for all of the patches' pixels that lie in the picture.
template <class F>
void for_each_pixel(const Overlay& overlay, int width, int height, F&& f) {
  for (const Patch& patch : overlay)
    for (int y = std::max(0, -patch.y); y < std::min(patch.height, height - patch.y); ++y)
      for (int x = std::max(0, -patch.x); x < std::min(patch.width, width - patch.x); ++x) {
        const float* rgba =
            patch.rgba.data() + 4 * (std::size_t(y) * std::size_t(patch.width) + std::size_t(x));
        if (rgba[3] > 0) f(rgba, std::size_t(y + patch.y) * std::size_t(width) + std::size_t(x + patch.x));
      }
}

/// Where Debian, Fedora, Arch and SUSE put sans serifs that have Greek letters and signs.
constexpr std::array usual_fonts{
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
    "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
    "/usr/share/fonts/TTF/DejaVuSans.ttf",
    "/usr/share/fonts/truetype/DejaVuSans.ttf",
    "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
    "/usr/share/fonts/liberation-sans/LiberationSans-Regular.ttf",
    "/usr/share/fonts/truetype/liberation2/LiberationSans-Regular.ttf",
    "/usr/share/fonts/truetype/freefont/FreeSans.ttf",
};

std::string find_font() {
  std::error_code ignored;
  if (const char* const named = std::getenv("RINGSPLAT_FONT"); named != nullptr && *named != '\0') {
    if (std::filesystem::is_regular_file(named, ignored)) return named;
    throw InputError(fmt::format("RINGSPLAT_FONT names {}, which is no file", named),
                     "name a TrueType font, such as DejaVuSans.ttf");
  }
  for (const char* const font : usual_fonts)
    if (std::filesystem::is_regular_file(font, ignored)) return font;
  throw InputError("there is no font to draw text with",
                   "install Debian's fonts-dejavu-core, or name a TrueType font in RINGSPLAT_FONT");
}

}  // namespace

Mask text_mask(const std::string& text, int pixels) {
  static const std::string font = find_font();
  Mask drawn;
  const std::string problem = image_library().draw_text(text, pixels, font, drawn);
  if (!problem.empty())
    throw InputError(fmt::format("no text can be drawn with {}: {}", font, problem),
                     "name another TrueType font in RINGSPLAT_FONT");
  return drawn;
}

Mask line_mask(const glm::dvec2& from, const glm::dvec2& to, double thickness) {
  const double reach = 0.5 * thickness + 1;
  const glm::dvec2 low = glm::floor(glm::min(from, to) - reach), high = glm::ceil(glm::max(from, to) + reach);
  Mask mask{int(low.x), int(low.y), int(high.x - low.x), int(high.y - low.y), {}};
  mask.coverage.reserve(std::size_t(mask.width) * std::size_t(mask.height));
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const double away = distance_to_segment(low + glm::dvec2(x + 0.5, y + 0.5), from, to);
      mask.coverage.push_back(float(std::clamp(0.5 * thickness + 0.5 - away, 0.0, 1.0)));
    }
  return mask;
}

Patch inked(const Mask& mask, const glm::dvec3& ink, const glm::dvec3& halo, double halo_pixels) {
  const Mask wide = grown(mask, halo_pixels);
  Patch patch{wide.x, wide.y, wide.width, wide.height, {}};
  patch.rgba.reserve(4 * wide.coverage.size());
  for (int y = 0; y < wide.height; ++y)
    for (int x = 0; x < wide.width; ++x) {
      const int mx = x + wide.x - mask.x, my = y + wide.y - mask.y;
      const bool inside = mx >= 0 && my >= 0 && mx < mask.width && my < mask.height;
      const float in = inside ? mask.coverage[mask.place(mx, my)] : 0.0F;
      const float around = (1 - in) * wide.coverage[wide.place(x, y)];
      for (int c = 0; c < 3; ++c) patch.rgba.push_back(in * float(ink[c]) + around * float(halo[c]));
      patch.rgba.push_back(in + around);
    }
  return patch;
}

void lay_over(const Overlay& overlay, int width, int height, int channels, std::span<std::uint8_t> display) {
  for_each_pixel(overlay, width, height, [&](const float* over, std::size_t pixel) {
    std::uint8_t* const value = display.data() + pixel * std::size_t(channels);
    const float below = (channels == 4 ? float(value[3]) / 255 : 1.0F) * (1 - over[3]),
                alpha = over[3] + below;
    for (int c = 0; c < 3; ++c) value[c] = to_byte((over[c] + below * float(value[c]) / 255) / alpha);
    if (channels == 4) value[3] = to_byte(alpha);
  });
}

void lay_over(const Overlay& overlay, int width, int height, int channels, std::span<float> linear) {
  for_each_pixel(overlay, width, height, [&](const float* over, std::size_t pixel) {
    float* const value = linear.data() + pixel * std::size_t(channels);
    for (int c = 0; c < 3; ++c)
      value[c] = over[3] * srgb_to_linear(over[c] / over[3]) + (1 - over[3]) * value[c];
    if (channels == 4) value[3] = over[3] + (1 - over[3]) * value[3];
  });
}

}  // namespace ringsplat

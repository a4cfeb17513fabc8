#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <filesystem>

#include "images/drawing.hpp"
#include "images/image_library.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/config.hpp"

namespace ringsplat {
namespace {

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
  if (!RINGSPLAT_WITH_OPENIMAGEIO)
    throw InputError("text is drawn by OpenImageIO, which this build does without",
                     "leave out --annotate, or build it with -DRINGSPLAT_WITH_OPENIMAGEIO=ON");
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

const std::string& text_font() {
  static const std::string found = find_font();
  return found;
}

Mask text_mask(const std::string& text, int pixels) {
  Mask drawn;
  const std::string problem = image_library().draw_text(text, pixels, text_font(), drawn);
  if (!problem.empty())
    throw InputError(fmt::format("no text can be drawn with {}: {}", text_font(), problem),
                     "name another TrueType font in RINGSPLAT_FONT");
  return drawn;
}

}  // namespace ringsplat

#include "options/likely_option.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

/// Options of ParaView, VTK, matplotlib, Fiji, Slicer and the like.
struct Word {
  const char *theirs, *ours;
  const char* more = "";
};
constexpr const char* no_maximum =
    " There is no maximum intensity projection: --tf grey --shading none comes near.";
constexpr const char* no_surface = " Opacity that rises steeply at a value shows a surface there.";
constexpr const char* or_whole = " --tf changes opacities, too.";
constexpr Word words[] = {
    {"window", "range"},
    {"window-level", "range"},
    {"level", "range"},
    {"clim", "range"},
    {"vmin", "range"},
    {"vmax", "range"},
    {"cmap", "colours", or_whole},
    {"colormap", "colours", or_whole},
    {"colourmap", "colours", or_whole},
    {"color-map", "colours", or_whole},
    {"colors", "colours", or_whole},
    {"lut", "colours", or_whole},
    {"palette", "colours", or_whole},
    {"transfer-function", "tf"},
    {"preset", "tf"},
    {"mip", "tf", no_maximum},
    {"projection-mode", "tf", no_maximum},
    {"iso", "tf", no_surface},
    {"isosurface", "tf", no_surface},
    {"isovalue", "tf", no_surface},
    {"contour", "tf", no_surface},
    {"alpha", "opacity"},
    {"density", "opacity"},
    {"resolution", "size"},
    {"width", "size"},
    {"height", "size"},
    {"camera", "eye"},
    {"camera-position", "eye"},
    {"position", "eye"},
    {"focal-point", "target"},
    {"look-at", "target"},
    {"view-up", "up"},
    {"rotate", "azimuth"},
    {"angle", "azimuth"},
    {"turntable", "orbit"},
    {"crop", "clip"},
    {"roi", "clip"},
    {"timestep", "frame"},
    {"threads", "threads-per-rank"},
    {"jobs", "threads-per-rank"},
    {"bgcolor", "background"},
    {"dtype", "type"},
    {"shape", "dims"},
    {"voxel-size", "spacing"},
    {"sampling-rate", "quality"},
};

std::string plain(const std::string& name) {
  std::string text = name.substr(std::min(name.find_first_not_of('-'), name.size()));
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

}  // namespace

std::string likely_option(const std::string& unknown, const std::vector<std::string>& known) {
  const auto word = std::find_if(std::begin(words), std::end(words),
                                 [&](const Word& w) { return w.theirs == plain(unknown); });
  if (word != std::end(words))
    for (const auto& name : known)
      if (plain(name) == word->ours) return fmt::format("did you mean {}?{}", name, word->more);
  const std::string alike = closest(unknown, known);
  return alike.empty() ? "" : fmt::format("did you mean {}?", alike);
}

}  // namespace ringsplat::app

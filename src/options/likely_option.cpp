#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"
#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

/// Options of ParaView, VTK, matplotlib, Fiji, Slicer and the like.
struct Alike {
  const char *ours, *theirs;
  const char* more = "";
};

constexpr const char* no_maximum =
    " There is no maximum intensity projection: --tf grey --shading none comes near.";
constexpr const char* no_surface = " Opacity that rises steeply at a value shows a surface there.";
constexpr const char* or_whole = " --tf changes opacities, too.";
constexpr Alike table[] = {
    {"range", "window window-level level clim vmin vmax"},
    {"colours", "cmap colormap colourmap color-map colors lut palette", or_whole},
    {"tf", "transfer-function preset"},
    {"tf", "mip projection-mode", no_maximum},
    {"tf", "iso isosurface isovalue contour", no_surface},
    {"opacity", "alpha density"},
    {"size", "resolution width height"},
    {"eye", "camera camera-position position"},
    {"target", "focal-point look-at"},
    {"up", "view-up"},
    {"azimuth", "rotate angle"},
    {"orbit", "turntable"},
    {"clip", "crop roi"},
    {"frame", "timestep"},
    {"threads-per-rank", "threads jobs"},
    {"background", "bgcolor"},
    {"type", "dtype"},
    {"dims", "shape"},
    {"spacing", "voxel-size"},
    {"quality", "sampling-rate"},
};

std::string plain(const std::string& name) {
  std::string text = name.substr(std::min(name.find_first_not_of('-'), name.size()));
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

}  // namespace

std::string likely_option(const std::string& unknown, const std::vector<std::string>& known) {
  for (const auto& [ours, theirs, more] : table)
    for (const std::string& word : detail::words_of(theirs))
      for (const auto& name : known)
        if (word == plain(unknown) && plain(name) == ours)
          return fmt::format("did you mean {}?{}", name, more);
  const std::string alike = closest(unknown, known);
  return alike.empty() ? "" : fmt::format("did you mean {}?", alike);
}

}  // namespace ringsplat::app

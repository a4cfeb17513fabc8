#include "serve/viewer.hpp"

#include <algorithm>

#include "base/process.hpp"
#include "classify/auto_preset.hpp"

namespace ringsplat::serve {

LoadOptions needed_for_levels(const FrameSpec& frame, const Grid& grid) {
  LoadOptions load = needed_along(frame, {true, true, true});
  load.factors.clear();
  load.clip.reset();  // pages move it
  for (const Level& level : make_levels(grid.dims))
    if (std::find(load.factors.begin(), load.factors.end(), level.undersample) == load.factors.end())
      load.factors.push_back(level.undersample);
  return load;
}

int largest_side() {
  constexpr int most = 4096, least = 1024;
  const double machine = machine_memory_bytes();
  int side = most;
  while (side > least && 64.0 * side * side > machine / 4) side /= 2;
  return side;
}

void set_modes(const TransferFunction& usual, const ValueStatistics& values, ViewerOptions& options) {
  Shown& shown = options.initial.shown;
  if (shown.interpolation == Interpolation::nearest) return;
  if (shown.mode != Mode::surface) shown.isovalue = parting_value(values);
  for (const Mode mode : every_mode)
    options.modes.emplace_back(
        mode, mode == Mode::composite ? usual : choose_for_mode(mode, values, std::nullopt).function);
}

}  // namespace ringsplat::serve

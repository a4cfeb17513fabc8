#include "serve/viewer.hpp"

#include <algorithm>

#include "base/process.hpp"
#include "classify/auto_preset.hpp"
#include "frame/frame_geometry.hpp"

namespace ringsplat::serve {

LoadOptions needed_for_levels(const FrameSpec& frame, const Grid& grid) {
  LoadOptions load{{true, true, true},
                   needs_normals(frame),
                   {},
                   frame.shown.reduction.prefilter,
                   needs_cell_ranges(frame)};
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

std::vector<std::pair<Mode, TransferFunction>> modes_for(const TransferFunction& usual,
                                                         const ValueStatistics& values, const Grid& grid) {
  std::vector<std::pair<Mode, TransferFunction>> modes{{Mode::composite, usual}};
  for (const Mode mode : {Mode::mip, Mode::minip, Mode::mean, Mode::sum, Mode::surface})
    modes.emplace_back(mode, choose_for_mode(mode, values, grid, std::nullopt).function);
  return modes;
}

}  // namespace ringsplat::serve

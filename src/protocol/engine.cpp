#include "protocol/engine.hpp"

#include <numeric>

namespace ringsplat {

std::vector<bool> FramePlan::drawing(int renderers) const {
  std::vector<bool> has_tile(std::size_t(renderers), false);
  for (const Tile& tile : tiles)
    if (tile.renderer != nobody) has_tile[std::size_t(tile.renderer)] = true;
  return has_tile;
}

int FramePlan::slices() const {
  return slices_of_steps.empty() ? int(owners.size())
                                 : std::accumulate(slices_of_steps.begin(), slices_of_steps.end(), 0);
}

}  // namespace ringsplat

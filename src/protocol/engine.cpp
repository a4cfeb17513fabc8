#include "protocol/engine.hpp"

namespace ringsplat {

std::vector<bool> FramePlan::drawing(int renderers) const {
  std::vector<bool> has_tile(std::size_t(renderers), false);
  for (const Tile& tile : tiles)
    if (tile.renderer != nobody) has_tile[std::size_t(tile.renderer)] = true;
  return has_tile;
}

}  // namespace ringsplat

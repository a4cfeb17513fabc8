#include "sheet_engine/visible_tiles.hpp"

#include <bit>

namespace ringsplat {
namespace {

constexpr int tiles_across = group_side / tile_side;
static_assert(tiles_across == 4);

}  // namespace

void VisibleTiles::lay_out(const Regions& all, const std::vector<int>& some) {
  all_ = all;
  regions_.assign(std::size_t(all.count()), {});
  groups_.clear();
  masks_.clear();
  for (std::size_t slot = 0; slot < some.size(); ++slot) {
    const PixelRect rect = all.rect(some[slot]);
    const int columns = (rect.width() + group_side - 1) / group_side,
              rows = (rect.height() + group_side - 1) / group_side;
    regions_[std::size_t(some[slot])] = {rect, groups_.size(), columns};
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) groups_.push_back({slot, column, row});
  }
}

bool VisibleTiles::mark(const PixelWindow& pixels) {
  const PixelRect touched = all_.touched(pixels);
  TileMask* masks = masks_.data() + masks_.size() - groups_.size();
  bool any = false;
  for (int y = touched.y0; y < touched.y1; ++y)
    for (int x = touched.x0; x < touched.x1; ++x)
      if (const Region& region = regions_[std::size_t(y * all_.columns() + x)]; region.columns > 0) {
        mark_region(region, pixels, masks);
        any = true;
      }
  return any;
}

std::size_t VisibleTiles::marked() const {
  std::size_t tiles = 0;
  for (std::size_t k = masks_.size() - groups_.size(); k < masks_.size(); ++k)
    if (masks_[k] != 0) tiles += std::size_t(std::popcount(masks_[k]));
  return tiles;
}

void VisibleTiles::mark_region(const Region& region, const PixelWindow& pixels, TileMask* masks) {
  const PixelRect& rect = region.rect;
  const auto tile = [](std::int64_t pixel, int first, int end) {
    return int(std::clamp<std::int64_t>(pixel, first, end - 1) - first) / tile_side;
  };
  const int left = tile(pixels.x0, rect.x0, rect.x1), right = tile(pixels.x1, rect.x0, rect.x1),
            top = tile(pixels.y0, rect.y0, rect.y1), bottom = tile(pixels.y1, rect.y0, rect.y1);
  for (int column = left / tiles_across; column <= right / tiles_across; ++column) {
    const int from = std::max(left - column * tiles_across, 0),
              to = std::min(right - column * tiles_across, tiles_across - 1);
    const unsigned across = (0xFU >> (3 - to)) & (0xFU << from);
    for (int row = top / tiles_across; row <= bottom / tiles_across; ++row) {
      const int first = std::max(top - row * tiles_across, 0),
                last = std::min(bottom - row * tiles_across, tiles_across - 1);
      unsigned mask = 0;
      for (int y = first; y <= last; ++y) mask |= across << (y * tiles_across);
      TileMask& here = masks[region.first_group + std::size_t(row * region.columns + column)];
      here = TileMask(here | mask);
    }
  }
}

}  // namespace ringsplat

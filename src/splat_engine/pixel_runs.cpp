#include "splat_engine/pixel_runs.hpp"

#include <algorithm>

namespace ringsplat {

PixelRuns::PixelRuns(std::span<const PixelRect> rects) : rects_(rects), rows_(rects.size()) {}

void PixelRuns::include(int region, const PixelWindow& window) {
  const PixelRect& rect = rects_[std::size_t(region)];
  const auto inside = [](std::int64_t pixel, int first, int pixels) {
    return int(std::clamp<std::int64_t>(pixel - first, 0, pixels));
  };
  const int x0 = inside(window.x0, rect.x0, rect.width()), x1 = inside(window.x1 + 1, rect.x0, rect.width()),
            y0 = inside(window.y0, rect.y0, rect.height()),
            y1 = inside(window.y1 + 1, rect.y0, rect.height());
  if (x0 >= x1 || y0 >= y1) return;
  std::vector<PixelRun>& rows = rows_[std::size_t(region)];
  if (rows.empty()) rows.resize(std::size_t(rect.height()));
  for (int y = y0; y < y1; ++y) rows[std::size_t(y)].include(x0, x1);
}

void PixelRuns::join(PixelRuns& other, int region) {
  std::vector<PixelRun>&rows = rows_[std::size_t(region)], &added = other.rows_[std::size_t(region)];
  if (rows.empty()) {
    std::swap(rows, added);
    return;
  }
  for (std::size_t y = 0; y < added.size(); ++y)
    if (!added[y].empty()) rows[y].include(added[y].first, added[y].end);
  added.clear();
}

std::uint64_t PixelRuns::take(int region) {
  std::uint64_t pixels = 0;
  for (PixelRun& run : rows_[std::size_t(region)]) {
    if (!run.empty())
      pixels += std::uint64_t(in_whole_blocks(run.end) - run.first / block_pixels * block_pixels);
    run = {};
  }
  return pixels;
}

}  // namespace ringsplat

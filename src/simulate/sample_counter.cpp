#include "simulate/sample_counter.hpp"

#include <algorithm>

#include "sheet_engine/paint_group.hpp"

namespace ringsplat {

SampleCounter::SampleCounter(const SheetFrame& frame, int finer)
    : frame_(frame), windows_(frame.geometry, finer) {
  std::size_t tiles = 0;
  const Regions& regions = frame.geometry.regions;
  for (int region = 0; region < regions.count(); ++region) {
    const PixelRect rect = regions.rect(region);
    const int columns = (rect.width() + tile_side - 1) / tile_side,
              rows = (rect.height() + tile_side - 1) / tile_side;
    regions_.push_back({rect, tiles, columns});
    tiles += std::size_t(columns) * std::size_t(rows);
  }
  before_.resize(tiles);
  behind_.resize(tiles);
}

void SampleCounter::begin(int step, int renderers) {
  step_ = step;
  samples_.assign(std::size_t(renderers), 0);
  if (step == 0) std::fill(before_.begin(), before_.end(), false);
  std::fill(behind_.begin(), behind_.end(), false);
}

void SampleCounter::add(int column, int row) {
  const int slice = frame_.slice_at(step_);
  if (step_ == 0) mark(windows_.before_first.of(column, row, slice), before_);
  mark(windows_.behind(step_).of(column, row, slice), behind_);
}

void SampleCounter::mark(const PixelWindow& pixels, std::vector<bool>& marked) {
  const Regions& all = frame_.geometry.regions;
  const PixelRect touched = all.touched(pixels.x0, pixels.y0, pixels.x1, pixels.y1);
  const auto tile = [](std::int64_t pixel, int first, int end) {
    return int(std::clamp<std::int64_t>(pixel, first, end - 1) - first) / tile_side;
  };
  for (int y = touched.y0; y < touched.y1; ++y)
    for (int x = touched.x0; x < touched.x1; ++x) {
      const auto number = std::size_t(y * all.columns() + x);
      const int renderer = frame_.plan.tiles[number].renderer;
      if (renderer == FramePlan::nobody) continue;
      const auto& [rect, first, columns] = regions_[number];
      const int left = tile(pixels.x0, rect.x0, rect.x1), right = tile(pixels.x1, rect.x0, rect.x1),
                top = tile(pixels.y0, rect.y0, rect.y1), bottom = tile(pixels.y1, rect.y0, rect.y1);
      for (int v = top; v <= bottom; ++v)
        for (int u = left; u <= right; ++u) {
          const std::size_t here = first + std::size_t(v) * std::size_t(columns) + std::size_t(u);
          if (!marked[here]) samples_[std::size_t(renderer)] += tile_side * tile_side;
          marked[here] = true;
        }
    }
}

}  // namespace ringsplat

#include "raster/warp_image.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "raster/warp_rows.hpp"

namespace ringsplat {
namespace {

/// Narrows columns [first, end) to those with low ≤ start + step · x ≤ high.
void narrow(double start, double step, double low, double high, double& first, double& end) {
  if (step == 0) {
    if (!(start >= low && start <= high)) end = first;
    return;
  }
  const double a = (low - start) / step, b = (high - start) / step;
  first = std::max(first, std::ceil(std::min(a, b)));
  end = std::min(end, std::floor(std::max(a, b)) + 1);
}

bool lies_within(const WarpedRow& row, int x, const PixelWindow& firsts) {
  const double px = std::fma(row.step_x, double(x), row.start_x),
               py = std::fma(row.step_y, double(x), row.start_y);
  return px >= double(firsts.x0) && px < double(firsts.x1 + 1) && py >= double(firsts.y0) &&
         py < double(firsts.y1 + 1);
}

bool is_clear(const float* pixel) {
  return std::all_of(pixel, pixel + 4, [](float value) { return value == 0; });
}

/// The smallest part of `window` with all of its pixels that are not 0; empty when all are.
PixelWindow not_clear(const Image& plane, const PixelWindow& window) {
  PixelWindow found{plane.width, plane.height, -1, -1};
  for (std::int64_t y = window.y0; y <= window.y1; ++y) {
    const float* row = plane.pixel(0, int(y));
    std::int64_t first = window.x0, last = window.x1;
    while (first <= last && is_clear(row + 4 * first)) ++first;
    if (first > last) continue;
    while (is_clear(row + 4 * last)) --last;
    found = {std::min(found.x0, first), std::min(found.y0, y), std::max(found.x1, last), y};
  }
  return found;
}

/// The screen's row y, narrowed to the pixels whose first taps lie in `firsts`.
WarpedRow seen_of_row(const Image& plane, const PixelWindow& firsts, const PlaneWarp& warp, int y,
                      int width) {
  // The first tap's centre lies between one and two pixels before the position.
  const glm::dvec2 start = warp.from_screen({0.5, y + 0.5}) - 1.5;
  WarpedRow row{plane.rgba.data(),
                std::ptrdiff_t{4} * plane.width,
                start.x,
                start.y,
                warp.linear[0].x,
                warp.linear[0].y,
                0,
                0};
  if (firsts.x0 > firsts.x1 || firsts.y0 > firsts.y1) return row;
  double first = 0, end = width;
  narrow(row.start_x, row.step_x, double(firsts.x0), double(firsts.x1 + 1), first, end);
  narrow(row.start_y, row.step_y, double(firsts.y0), double(firsts.y1 + 1), first, end);
  if (!(first < end)) return row;
  row.first = static_cast<int>(first);
  row.end = static_cast<int>(end);
  // Rounding may have left a column too many at either end.
  while (row.first < row.end && !lies_within(row, row.first, firsts)) ++row.first;
  while (row.first < row.end && !lies_within(row, row.end - 1, firsts)) --row.end;
  return row;
}

}  // namespace

Image warp_image(const Image& plane, const PixelWindow& window, const PlaneWarp& warp, int width,
                 int height) {
  const PixelWindow filled = not_clear(plane, window);
  // The first of a position's four taps along each axis: one of the four must see a filled pixel, and all
  // must lie in the image.
  const PixelWindow firsts{std::max<std::int64_t>(filled.x0 - 3, 0), std::max<std::int64_t>(filled.y0 - 3, 0),
                           std::min<std::int64_t>(filled.x1, plane.width - 4),
                           std::min<std::int64_t>(filled.y1, plane.height - 4)};
  std::vector<WarpedRow> rows;
  for (int y = 0; y < height; ++y) rows.push_back(seen_of_row(plane, firsts, warp, y, width));
  Image screen = Image::uninitialised(width, height);
  for (int y = 0; y < height; ++y) {
    const WarpedRow& row = rows[std::size_t(y)];
    std::fill(screen.pixel(0, y), screen.pixel(row.first, y), 0.0F);
    std::fill(screen.pixel(row.end, y), screen.pixel(0, y + 1), 0.0F);
  }
  if (warp.linear[1].x == 0)
    warp_columns(rows, int(firsts.y0), int(firsts.y1), screen);
  else
    for (int y = 0; y < height; ++y) warp_row(rows[std::size_t(y)], screen.pixel(0, y));
  return screen;
}

}  // namespace ringsplat

#include "screen/regions.hpp"

#include <fmt/format.h>

#include <limits>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr int largest_side = 1 << 20;

int regions_along(int length, int size) { return (length - 1) / size + 1; }

/// Square of the shortest way, in regions, from one region to another of the same Renderer in an endless
/// image.
std::int64_t shortest_way(std::int64_t skew, std::int64_t renderers) {
  std::int64_t shortest = renderers * renderers;
  for (std::int64_t y = 1; y * y < shortest; ++y) {
    const std::int64_t along = skew * y % renderers, x = std::min(along, renderers - along);
    shortest = std::min(shortest, x * x + y * y);
  }
  return shortest;
}

/// Whether all Renderers have equally many regions or one fewer.
bool is_even(int columns, int rows, std::int64_t skew, int renderers) {
  std::vector<int> owned(std::size_t(renderers), 0);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) ++owned[std::size_t((x + skew * y) % renderers)];
  const auto [least, most] = std::minmax_element(owned.begin(), owned.end());
  return *most - *least <= 1;
}

std::int64_t choose_skew(int columns, int rows, int renderers) {
  std::vector<std::pair<std::int64_t, std::int64_t>> skews;  // by shortest way, longest first
  for (std::int64_t skew = 0; skew < renderers; ++skew)
    skews.emplace_back(-shortest_way(skew, renderers), skew);
  // So many are enough to find an even one wherever there is one besides the last.
  constexpr std::size_t most_tried = 16;
  const std::size_t tried = std::min(skews.size(), most_tried);
  std::partial_sort(skews.begin(), skews.begin() + std::ptrdiff_t(tried), skews.end());
  for (std::size_t k = 0; k < tried; ++k)
    if (is_even(columns, rows, skews[k].second, renderers)) return skews[k].second;
  return columns % renderers;
}

}  // namespace

Regions::Regions(int width, int height, int region_width, int region_height)
    : width_(width), height_(height), region_width_(region_width), region_height_(region_height) {
  if (width < 1 || height < 1 || width > largest_side || height > largest_side)
    throw InputError(
        fmt::format("image size {}x{} is not within 1 to {} pixels a side", width, height, largest_side),
        "give a size such as --size 512x512");
  if (region_width < 1 || region_height < 1)
    throw InputError(fmt::format("region size {} is not positive", std::min(region_width, region_height)),
                     "give the pixels of a region's side, such as --region 128");
  columns_ = regions_along(width, region_width);
  rows_ = regions_along(height, region_height);
  if (std::int64_t{columns_} * rows_ > std::numeric_limits<std::int32_t>::max())
    throw InputError(fmt::format("an image of {}x{} pixels has too many regions of {}x{} pixels ({} x {})",
                                 width, height, region_width, region_height, columns_, rows_),
                     "choose larger regions, such as --region 128");
}

std::vector<int> Regions::owners(const PixelRect& block, int renderers, int dealt_to) const {
  const std::int64_t skew = choose_skew(block.width(), block.height(), dealt_to);
  std::vector<int> owner(std::size_t(count()), nobody);
  for (int y = block.y0; y < block.y1; ++y)
    for (int x = block.x0; x < block.x1; ++x)
      owner[std::size_t(y * columns_ + x)] =
          int((x - block.x0 + (y - block.y0) * skew) % dealt_to * renderers / dealt_to);
  return owner;
}

PixelRect Regions::touched(const PixelWindow& pixels) const {
  const std::int64_t x0 = std::max<std::int64_t>(pixels.x0, 0), y0 = std::max<std::int64_t>(pixels.y0, 0),
                     x1 = std::min<std::int64_t>(pixels.x1, width_ - 1),
                     y1 = std::min<std::int64_t>(pixels.y1, height_ - 1);
  if (x0 > x1 || y0 > y1) return {};
  return {int(x0 / region_width_), int(y0 / region_height_), int(x1 / region_width_) + 1,
          int(y1 / region_height_) + 1};
}

}  // namespace ringsplat

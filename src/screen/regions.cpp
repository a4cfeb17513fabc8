#include "screen/regions.hpp"

#include <fmt/format.h>

#include <limits>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr int largest_side = 1 << 20;

int regions_along(int length, int size) { return (length - 1) / size + 1; }

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

PixelRect Regions::touched(const PixelWindow& pixels) const {
  const std::int64_t x0 = std::max<std::int64_t>(pixels.x0, 0), y0 = std::max<std::int64_t>(pixels.y0, 0),
                     x1 = std::min<std::int64_t>(pixels.x1, width_ - 1),
                     y1 = std::min<std::int64_t>(pixels.y1, height_ - 1);
  if (x0 > x1 || y0 > y1) return {};
  // Processors divide small numbers faster.
  return {int(x0) / region_width_, int(y0) / region_height_, int(x1) / region_width_ + 1,
          int(y1) / region_height_ + 1};
}

}  // namespace ringsplat

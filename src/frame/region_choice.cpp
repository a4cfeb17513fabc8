#include "frame/frame_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "screen/regions.hpp"

namespace ringsplat {
namespace {

int round_up(int value, int step) { return (value + step - 1) / step * step; }

/// Pixels of the image plane that the kernels of the volume's voxels can reach.
PixelWindow reached_pixels(const FrameGeometry& g) {
  glm::dvec2 low{INFINITY}, high{-INFINITY};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 far{corner & 1, corner >> 1 & 1, corner >> 2};
    // A voxel's reach is not the same all over a perspective view; no ray sees anything beyond the faces.
    const glm::dvec3 end =
        g.view.eye ? glm::dvec3(far * g.grid.dims) - 0.5 : glm::dvec3(far * (g.grid.dims - 1));
    if (!std::isfinite(g.view.magnification(end))) return {0, 0, g.width, g.height};
    const glm::dvec2 at = g.view.seen_at(end);
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  // A margin: GPs step from voxel to voxel with rounding, and round windows outwards.
  const glm::dvec2 around = (g.view.eye ? glm::dvec2(0.0) : glm::trunc(g.reach)) + 3.0;
  const glm::dvec2 before(-1.0), behind(g.width, g.height);
  low = glm::clamp(glm::floor(low - around), before, behind);
  high = glm::clamp(glm::ceil(high + around), before, behind);
  return {std::int64_t(low.x), std::int64_t(low.y), std::int64_t(high.x), std::int64_t(high.y)};
}

PixelRect touched(const Regions& regions, const PixelWindow& pixels) {
  return regions.touched(pixels.x0, pixels.y0, pixels.x1, pixels.y1);
}

/// In the slices' plane a row of voxels is a row of pixels, so regions are strips as wide as the image: no
/// row is cut, unless there are more Renderers than strips. The image there is small, and the volume covers
/// all of it; still every Renderer should get strips from several parts.
Regions strips(int renderers, int width, int height) {
  constexpr int each = 3, least_rows = 16, most_rows = 64, least_columns = 64;
  const int region_height =
      std::clamp(round_up(height / (each * renderers), least_rows), least_rows, most_rows);
  const int rows = Regions(width, height, width, region_height).rows(),
            columns = std::max(renderers / rows, 1);
  const int region_width =
      columns == 1 ? width : std::max(round_up(width / columns, least_columns), least_columns);
  return {width, height, region_width, region_height};
}

/// Strips of one row of pixel groups: neighbouring rows cost nearly the same, so Renderers that take them in
/// turn have even loads. Where Renderers are many, strips are cut so that each still gets several.
Regions low_strips(int renderers, const PixelWindow& reached, int width, int height) {
  constexpr int each = 4, region_height = 16, least_columns = 64;
  const std::int64_t rows = std::max<std::int64_t>((reached.y1 - reached.y0) / region_height, 1);
  const int columns = int(std::max<std::int64_t>((std::int64_t{each} * renderers + rows - 1) / rows, 1));
  if (rows >= std::int64_t{each} * renderers || columns == 1) return {width, height, width, region_height};
  const int reached_width = int(std::max<std::int64_t>(reached.x1 - reached.x0, 1));
  return {width, height, std::min(width, std::max(round_up(reached_width / columns, 16), least_columns)),
          region_height};
}

}  // namespace

PixelRect reached_regions(const FrameGeometry& g, const Regions& regions) {
  return touched(regions, reached_pixels(g));
}

void lay_regions(FrameGeometry& g, const FrameSpec& spec) {
  const Division& division = spec.division;
  const int renderers = std::clamp(division.dealt_to, 1, 1 << 16);
  const PixelWindow reached = reached_pixels(g);
  constexpr int usual_side = 128;
  if (division.region_size > 0)
    g.regions = {g.width, g.height, division.region_size};
  else if (std::holds_alternative<Sheets>(spec.how))
    // Low strips share out evenly what costs by the pixel. Squares suit splats, which regions cut.
    g.regions = low_strips(renderers, reached, g.width, g.height);
  else if (!g.warp)
    g.regions = {g.width, g.height, usual_side};
  else
    g.regions = strips(renderers, g.width, g.height);
  g.reached = touched(g.regions, reached);
  g.dealt_to = division.dealt_to;
}

}  // namespace ringsplat

#include "frame/frame_geometry.hpp"

#include <fmt/format.h>

#include <cmath>
#include <glm/common.hpp>

#include "ringsplat/base/error.hpp"
#include "splat/footprint.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

/// The view of a lattice, from the lattice that begins at its voxel `first`.
ViewTransform moved_view(ViewTransform view, const glm::ivec3& first) {
  view.offset = view.project(glm::dvec3(first));
  if (view.eye) *view.eye -= glm::dvec3(first);
  return view;
}

/// The traversal of a part of the volume: in perspective the eye must lie outside of the part only.
Traversal traversal_of(const ViewTransform& view, const Grid& grid, const VoxelBox& box, SliceRule rule) {
  return choose_traversal(moved_view(view, box.first), lattice_frame(clipped_grid(grid, box)), rule);
}

SliceRule slice_rule(const Method& how) {
  return std::holds_alternative<Sheets>(how) ? SliceRule::most_crossed : SliceRule::most_parallel;
}

void lay_into_slices(FrameGeometry& g, const Shown& shown, double samples, double reach_in_voxels,
                     double least = 0) {
  const SlicePlane plane = make_slice_plane(g.view, g.traversal.axis, g.grid.dims, samples, reach_in_voxels,
                                            shown.width, shown.height, least);
  g.view = plane.view;
  g.warp = plane.warp;
  g.width = plane.width;
  g.height = plane.height;
}

/// Geometry of the volume on the screen.
FrameGeometry screen_geometry(const Shown& shown, const Grid& grid, SliceRule rule) {
  FrameGeometry g;
  g.view = make_view(shown.camera, lattice_frame(grid), shown.width, shown.height);
  g.grid = grid;
  if (shown.clip) check(*shown.clip, grid);
  g.box = shown.clip.value_or(whole_box(grid));
  g.traversal = traversal_of(g.view, grid, g.box, rule);
  // Where a reduced volume's first voxel lies in the volume's lattice, along each axis.
  const double factor = shown.reduction.factor,
               first_reduced = shown.reduction.prefilter ? 0.5 * (factor - 1) : 0.0;
  if (shown.reduction.factor > 1) {
    g.grid = reduced_grid(grid, shown.reduction);
    g.box = shown.clip ? reduced_box(*shown.clip, grid, shown.reduction) : whole_box(g.grid);
    // Shows the reduced volume's lattice where the volume is.
    g.view.offset = g.view.project(glm::dvec3(first_reduced));
    g.view.linear *= factor;
    if (g.view.eye) *g.view.eye = (*g.view.eye - first_reduced) / factor;
    // The reduced box may be larger, so that the eye lies among its slices. Only the whole's are loaded.
    if (g.view.eye && traversal_of(g.view, g.grid, g.box, rule).axis != g.traversal.axis)
      throw InputError("the eye is too near to the volume to see it undersampled",
                       "use a larger --distance or --undersample 1");
    g.traversal.slice_distance *= shown.reduction.factor;
  }
  if (shown.clip) {
    g.view = moved_view(g.view, g.box.first);
    g.grid = clipped_grid(g.grid, g.box);
  }
  // The grid's first voxel in the lattice of the whole volume, whose voxels are `factor` times as small.
  const glm::dvec3 first = factor * glm::dvec3(g.box.first) + first_reduced,
                   middle = 0.5 * glm::dvec3(grid.dims - 1);
  for (const ClipPlane& plane : shown.clip_planes) {
    const glm::dvec3 normal = glm::normalize(plane.normal);
    glm::dvec3 along;
    for (int k = 0; k < 3; ++k) along[k] = glm::dot(normal, grid.direction[k]) * grid.spacing[k];
    const double length = factor * glm::length(along);
    g.clip_planes.push_back(
        {factor * along / length, (glm::dot(along, first - middle) - plane.distance) / length});
  }
  g.width = shown.width;
  g.height = shown.height;
  g.slices = g.grid.slices(g.traversal.axis);
  return g;
}

/// Chooses the image plane and sets how far a splat reaches in it.
void fit(FrameGeometry& g, const Shown& shown, const Splats& splats) {
  if (splats.image_plane == ImagePlane::slices)
    lay_into_slices(g, shown, splats.plane_samples, splats.kernel_radius);
  const Footprint footprint = make_footprint(g.view, g.traversal.axis, splats.kernel_radius);
  g.reach = footprint.half;
  constexpr double widest = 1 << 20;
  const double half = std::max(g.reach.x, g.reach.y);
  if (!(half < widest))
    throw InputError(fmt::format("a voxel's kernel would be {:.3g} pixels wide", 2 * half),
                     "use a smaller --zoom or --size");
}

/// A sheet's voxel is seen up to a lattice distance from its centre, or half of one beyond the box's faces.
void fit(FrameGeometry& g, const Shown& shown, const Sheets& sheets) {
  // Sheets err more in that plane, so they go there where it saves pixels only.
  constexpr double least = 1;
  // A warp is of colours, which lie between 0 and 1.
  if (sheets.image_plane == ImagePlane::slices && !g.view.eye && !shown.values &&
      plane_density(g.view, g.traversal.axis, sheets.plane_samples, least) <= 1)
    lay_into_slices(g, shown, sheets.plane_samples, 1.0, least);
  const auto [u, v] = in_plane(g.traversal.axis);
  const int k = static_cast<int>(g.traversal.axis);
  const glm::dmat3& linear = g.view.linear;
  g.reach = glm::abs(glm::dvec2(linear[u])) + glm::abs(glm::dvec2(linear[v])) +
            0.5 * glm::abs(glm::dvec2(linear[k]));
  double magnification = 0;  // the largest in the volume's box
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 far{corner & 1, corner >> 1 & 1, corner >> 2};
    magnification = std::max(magnification, g.view.magnification(far * glm::dvec3(g.grid.dims) - 0.5));
  }
  g.reach *= magnification;
}

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

/// Whether each Renderer of sheets gets one part of the image plane. Where blocks are smaller than strips,
/// far strips would take most of them to several Renderers, and others each time a view turns; a few
/// Renderers need nearly all in any case.
bool in_parts(const FrameGeometry& g, int renderers) {
  constexpr int few = 4, strip = 16;
  return renderers > few && CellRanges::side * std::max(g.reach.x, g.reach.y) < strip;
}

/// Strips of one row of pixel groups: neighbouring rows cost nearly the same, so Renderers that take them in
/// turn have even loads. Where Renderers are many, strips are cut so that each still gets several, and small
/// enough to be dealt evenly where those of a part lie side by side.
Regions low_strips(const FrameGeometry& g, int renderers, const PixelWindow& reached) {
  constexpr int region_height = 16;
  const std::int64_t each = g.in_parts ? 16 : 4;
  const int least_columns = g.in_parts ? 16 : 64;
  const std::int64_t rows = std::max<std::int64_t>((reached.y1 - reached.y0) / region_height, 1);
  const int columns = int(std::max<std::int64_t>((each * renderers + rows - 1) / rows, 1));
  if (rows >= each * renderers || columns == 1) return {g.width, g.height, g.width, region_height};
  const int reached_width = int(std::max<std::int64_t>(reached.x1 - reached.x0, 1));
  return {g.width, g.height,
          std::min(g.width, std::max(round_up(reached_width / columns, 16), least_columns)), region_height};
}

int layers_of(const FrameGeometry& g, int slices) { return (g.slices + slices - 1) / slices; }

/// Layers lie below each other, so that a Renderer whose regions are neighbours has those of few layers.
void stack_layers(FrameGeometry& g, int slices) {
  constexpr int most_rows = 1 << 20;
  const PixelRect first = g.regions.rect(0);
  g.layers = {slices, layers_of(g, slices), first.height() * g.regions.rows(), g.regions, g.reached};
  constexpr std::int64_t most_regions = 1 << 20;
  if (g.layers.height > most_rows / g.layers.count ||
      std::int64_t{g.regions.count()} * g.layers.count > most_regions)
    throw InputError(fmt::format("{} layers are too many for a picture of that size", g.layers.count),
                     fmt::format("use more slices than --layers {}", slices));
  g.regions = {g.width, g.layers.height * g.layers.count, first.width(), first.height()};
  g.reached.y0 = 0;
  g.reached.y1 = g.reached.empty() ? 0 : g.regions.rows();
}

/// Among how many Renderers a layer is shared out, so that all have regions of layers and of the picture.
int sharing_a_layer(const FrameGeometry& g, int slices, int renderers) {
  constexpr int regions_of_strips = 16;
  const int layers = std::min(layers_of(g, slices), regions_of_strips);
  return (renderers + layers - 1) / layers;
}

/// Owners by region: of the k-th in a block of regions, row by row, owner(k); the others are nobody's.
std::vector<int> owners_in(const Regions& regions, const PixelRect& block, auto&& owner) {
  std::vector<int> owners(std::size_t(regions.count()), nobody);
  std::int64_t k = 0;
  for (int y = block.y0; y < block.y1; ++y)
    for (int x = block.x0; x < block.x1; ++x)
      owners[std::size_t(y * regions.columns() + x)] = int(owner(k++));
  return owners;
}

}  // namespace

Axis traversed_axis(const FrameSpec& spec, const Grid& grid) {
  return screen_geometry(spec.shown, grid, slice_rule(spec.how)).traversal.axis;
}

FrameGeometry make_geometry(const FrameSpec& spec, const Grid& grid) {
  check_projection(spec.shown.camera, spec.how);
  FrameGeometry g = screen_geometry(spec.shown, grid, slice_rule(spec.how));
  std::visit([&](const auto& how) { fit(g, spec.shown, how); }, spec.how);
  lay_regions(g, spec);
  return g;
}

std::vector<int> FrameGeometry::owners(int renderers) const {
  if (!dealt.empty()) return dealt;
  const std::int64_t takers = dealt_to > 0 ? std::min(dealt_to, renderers) : renderers;
  return owners_in(regions, reached, [&](std::int64_t k) { return k % takers * renderers / takers; });
}

std::vector<int> FrameGeometry::tile_owners(int renderers) const {
  // Runs along the rows, so that all that draw have about as many.
  const std::int64_t takers = dealt_to > 0 ? std::min(dealt_to, renderers) : renderers,
                     all = std::int64_t{layers.reached.width()} * layers.reached.height();
  return owners_in(layers.picture, layers.reached,
                   [&](std::int64_t k) { return k * takers / all * renderers / takers; });
}

PixelRect reached_regions(const FrameGeometry& g, const Regions& regions) {
  return regions.touched(reached_pixels(g));
}

void lay_regions(FrameGeometry& g, const FrameSpec& spec) {
  const Division& division = spec.division;
  const auto* const sheets = std::get_if<Sheets>(&spec.how);
  const int layer = sheets != nullptr ? std::min(sheets->layers, std::max(g.slices, Sheets::least_layer)) : 0;
  int renderers = std::clamp(division.dealt_to, 1, 1 << 16);
  const PixelWindow reached = reached_pixels(g);
  constexpr int usual_side = 128;
  g.in_parts = layer > 0 || (sheets != nullptr && in_parts(g, renderers));
  if (layer > 0) renderers = sharing_a_layer(g, layer, renderers);
  if (division.region_size > 0)
    g.regions = {g.width, g.height, division.region_size};
  else if (sheets != nullptr)
    // Low strips share out evenly what costs by the pixel. Squares suit splats, which regions cut.
    g.regions = low_strips(g, renderers, reached);
  else if (!g.warp)
    g.regions = {g.width, g.height, usual_side};
  else
    g.regions = strips(renderers, g.width, g.height);
  g.reached = g.regions.touched(reached);
  g.dealt_to = division.dealt_to;
  if (layer > 0) stack_layers(g, layer);
}

}  // namespace ringsplat

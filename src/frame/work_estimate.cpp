#include "frame/work_estimate.hpp"

#include <cmath>
#include <glm/common.hpp>

#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

/// Pixels that a voxel of a slice covers; in perspective about its middle.
double pixels_of_voxel(const FrameGeometry& g) {
  const auto [u, v] = in_plane(g.traversal.axis);
  const glm::dvec2 a(g.view.linear[u]), b(g.view.linear[v]);
  const double magnified = g.view.magnification(0.5 * glm::dvec3(g.grid.dims));
  const double scale = std::isfinite(magnified) ? magnified : 1;
  return std::abs(a.x * b.y - a.y * b.x) * scale * scale;
}

struct ValueHull {
  float low = INFINITY, high = -INFINITY;
  void add(float value) {
    if (std::isnan(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool visible(const TransferFunction& function) const {
    return low <= high && function.visible_within(double(low), double(high));
  }
};

/// By point along an axis, the first one in its block.
std::vector<int> firsts_of_blocks(const VolumeSketch& sketch, int along, double side) {
  std::vector<int> firsts;
  int last_block = -1;
  for (int point = 0; point < sketch.points[along]; ++point) {
    const int block = int(sketch.voxel(along, point) / side);
    firsts.push_back(block == last_block ? firsts.back() : point);
    last_block = block;
  }
  return firsts;
}

/// By point, whether something is visible of the values of all points of its block of a slice and of the
/// block behind that.
std::vector<bool> visible_by_block(const VolumeSketch& sketch, const ShownPoints::Blocks& blocks,
                                   const TransferFunction& function) {
  const auto [u, v] = in_plane(blocks.across);
  const int k = static_cast<int>(blocks.across);
  const std::vector<int> firsts_u = firsts_of_blocks(sketch, u, blocks.side),
                         firsts_v = firsts_of_blocks(sketch, v, blocks.side);
  const std::array<int, 3> steps{1, sketch.points.x, sketch.points.x * sketch.points.y};
  const auto for_each_point = [&](auto&& visit) {
    for (int slice = 0; slice < sketch.points[k]; ++slice)
      for (int y = 0; y < sketch.points[v]; ++y) {
        const int row = slice * steps[k] + y * steps[v],
                  first_row = slice * steps[k] + firsts_v[std::size_t(y)] * steps[v];
        for (int x = 0; x < sketch.points[u]; ++x)
          visit(slice, std::size_t(row + x * steps[u]),
                std::size_t(first_row + firsts_u[std::size_t(x)] * steps[u]));
      }
  };
  // Collected at a block's first point, then handed to all.
  std::vector<ValueHull> hulls(sketch.values.size());
  for_each_point([&](int slice, std::size_t at, std::size_t first) {
    hulls[first].add(sketch.values[at]);
    if (slice > 0) hulls[first - std::size_t(steps[k])].add(sketch.values[at]);
  });
  std::vector<bool> visible(hulls.size());
  for_each_point([&](int, std::size_t at, std::size_t first) {
    visible[at] = first == at ? hulls[first].visible(function) : visible[first];
  });
  return visible;
}

}  // namespace

glm::dvec2 size_of_block(const FrameGeometry& g, double side) {
  constexpr double usual_reach = 2, rounding = 1;  // of gradients, in voxels; to whole pixels
  const auto [u, v] = in_plane(g.traversal.axis);
  const glm::dvec2 a(g.view.linear[u]), b(g.view.linear[v]),
      k(g.view.linear[static_cast<int>(g.traversal.axis)]);
  const double magnified = g.view.magnification(0.5 * glm::dvec3(g.grid.dims)),
               scale = std::isfinite(magnified) ? magnified : 1,
               in_plane_voxels = side * (1 + (2 * usual_reach - 1) / CellRanges::side);
  return scale * (in_plane_voxels * (glm::abs(a) + glm::abs(b)) + 2 * usual_reach * glm::abs(k)) + rounding;
}

std::span<const std::uint32_t> ShownPoints::of(const VolumeSketch& sketch, const TransferFunction& function,
                                               std::optional<Blocks> blocks) {
  const double side = blocks ? blocks->side : 0;
  if (!function_ || *function_ != function || side_ != side) {
    shown_ = {};
    function_ = function;
    side_ = side;
  }
  auto& kept = shown_[blocks ? static_cast<std::size_t>(blocks->across) : 0];
  if (kept) return *kept;
  std::vector<std::uint32_t>& shown = kept.emplace();
  std::vector<bool> visible;
  if (blocks) visible = visible_by_block(sketch, *blocks, function);
  for (std::size_t k = 0; k < sketch.values.size(); ++k) {
    ValueHull one;
    one.add(sketch.values[k]);
    if (blocks ? visible[k] : one.visible(function)) shown.push_back(std::uint32_t(k));
  }
  return shown;
}

WorkEstimate::WorkEstimate(const FrameGeometry& g, const VolumeSketch& sketch,
                           std::span<const std::uint32_t> shown, const WorkCosts& costs, int factor,
                           int only_layer, int stands_for)
    : traversal_(g.traversal), slices_(g.slices) {
  const int axis = static_cast<int>(g.traversal.axis);
  layers_ = sketch.points[axis];
  const glm::dvec3 level = glm::dvec3(sketch.dims) / double(factor),
                   spacing = level / glm::dvec3(sketch.points);
  voxels_of_point_ = spacing.x * spacing.y * spacing.z * stands_for;

  make_cells(g, spacing);
  around_ = costs.block > 0 ? 0.5 * size_of_block(g, costs.block) : g.reach;
  for (int along = 0; along < 2; ++along)
    if (!std::isfinite(around_[along])) around_[along] = 0;

  const double painting = costs.pixel * pixels_of_voxel(g),
               work = voxels_of_point_ * (costs.voxel + painting);
  if (painting > 0) painted_ = painting / (costs.voxel + painting);
  std::vector<int> shown_in(std::size_t(layers_), 0);
  const glm::dvec2 origin(g.view.project(0.5 * spacing - 0.5 - glm::dvec3(g.box.first))),
      along_x(g.view.linear[0] * spacing.x), along_y(g.view.linear[1] * spacing.y),
      along_z(g.view.linear[2] * spacing.z);
  const auto wide = std::uint32_t(sketch.points.x), high = std::uint32_t(sketch.points.y);
  for (const std::uint32_t index : shown) {
    const std::uint32_t row = index / wide;
    const glm::ivec3 point(int(index - row * wide), int(row % high), int(row / high));
    if (only_layer >= 0 && point[axis] != only_layer) continue;
    const glm::dvec3 voxel = (glm::dvec3(point) + 0.5) * spacing - 0.5 - glm::dvec3(g.box.first);
    const auto in_box =
        glm::greaterThanEqual(voxel, glm::dvec3(-0.5)) && glm::lessThan(voxel, glm::dvec3(g.grid.dims) - 0.5);
    if (!glm::all(in_box)) continue;
    glm::dvec2 place =
        origin + double(point.x) * along_x + double(point.y) * along_y + double(point.z) * along_z;
    if (g.view.eye) {
      if (!std::isfinite(g.view.magnification(voxel))) continue;
      place = g.view.seen_at(voxel);
    }
    ++points_;
    shown_in[std::size_t(point[axis])] += stands_for;
    if (g.layers.slices == 0) deposit(place, work, point[axis]);
    if (g.layers.slices == 0 || !(place.y >= 0 && place.y < g.height)) continue;
    // A point may stand for slices of several layers.
    const double from = std::max(voxel[axis] + 0.5 - 0.5 * spacing[axis], 0.0),
                 to = std::min(from + spacing[axis], double(g.slices)), thick = g.layers.slices;
    for (int layer = int(from / thick); layer * thick < to; ++layer)
      deposit(place + glm::dvec2(0, layer * g.layers.height),
              work * (std::min(to, (layer + 1) * thick) - std::max(from, layer * thick)) / spacing[axis],
              point[axis]);
  }
  for (int y = 0; y < rows_; ++y) {
    double row = 0;
    for (int x = 0; x < columns_; ++x) {
      double& here = work_[std::size_t(y) * std::size_t(columns_) + std::size_t(x)];
      row += here;
      here = row + (y > 0 ? work_[std::size_t(y - 1) * std::size_t(columns_) + std::size_t(x)] : 0);
    }
  }

  const auto [u, v] = in_plane(g.traversal.axis);
  const double slice = double(g.grid.slice_voxels(g.traversal.axis)), of_point = spacing[u] * spacing[v];
  for (const int count : shown_in) {
    const double visible = std::min(slice, count * of_point);
    slice_seconds_.push_back(visible * costs.visible + (slice - visible) * costs.hollow);
  }
  first_slice_ = g.box.first[axis];
  layer_of_slice_ = 1 / spacing[axis];
}

/// Cells as large as what a point stands for, within bounds.
void WorkEstimate::make_cells(const FrameGeometry& g, const glm::dvec3& spacing) {
  constexpr double most_cells = 96, least_cell = 4;
  for (int along = 0; along < 2; ++along) {
    double size = 0;
    for (int k = 0; k < 3 && !g.view.eye; ++k) size += std::abs(g.view.linear[k][along]) * spacing[k];
    cell_[along] = std::max({size, least_cell, double(along == 0 ? g.width : g.height) / most_cells});
  }
  double height = g.height;
  if (g.layers.slices > 0) {
    // Whole cells in each layer, fewer where layers are many.
    const double layer = g.layers.height, most = std::max(most_cells / std::sqrt(g.layers.count), 4.0);
    cell_.y = layer / std::max(1.0, std::floor(layer / std::max(cell_.y, layer / most)));
    height = layer * g.layers.count;
  }
  columns_ = int(std::ceil(g.width / cell_.x)) + 1;
  rows_ = int(std::ceil(height / cell_.y)) + 1;
  work_.assign(std::size_t(columns_) * std::size_t(rows_), 0);
  seen_.assign(work_.size(), 0);
}

/// Spreads a point's work over the four cells round it: lattices of points as far apart as cells become even.
void WorkEstimate::deposit(const glm::dvec2& place, double work, int layer) {
  const glm::dvec2 at = place * (1.0 / cell_) - 0.5;
  // Off the image plane, or on its left and upper edge, where cells are cut off.
  if (!(at.x >= -1 && at.y >= -1 && at.x < columns_ && at.y < rows_)) return;
  const int x = int(at.x + 1) - 1, y = int(at.y + 1) - 1;
  const double u = at.x - x, v = at.y - y;
  const std::uint64_t bit = std::uint64_t{1} << layer;
  const auto add = [&](int column, int row, double share) {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
    const std::size_t cell = std::size_t(row) * std::size_t(columns_) + std::size_t(column);
    work_[cell] += work * share;
    if (share >= 0.25) seen_[cell] |= bit;
  };
  add(x, y, (1 - u) * (1 - v));
  add(x + 1, y, u * (1 - v));
  add(x, y + 1, (1 - u) * v);
  add(x + 1, y + 1, u * v);
}

double WorkEstimate::within(double x0, double y0, double x1, double y1) const {
  // The sum over all work above and to the left of a place, bilinear between the cells' corners.
  const auto corner = [this](int x, int y) {
    x = std::min(x, columns_);
    y = std::min(y, rows_);
    return x <= 0 || y <= 0 ? 0 : work_[std::size_t(y - 1) * std::size_t(columns_) + std::size_t(x - 1)];
  };
  const auto sum = [&](double x, double y) {
    const double u = std::clamp(x / cell_.x, 0.0, double(columns_)),
                 v = std::clamp(y / cell_.y, 0.0, double(rows_));
    const int i = int(u), j = int(v);
    const double fu = u - i, fv = v - j;
    return (1 - fv) * ((1 - fu) * corner(i, j) + fu * corner(i + 1, j)) +
           fv * ((1 - fu) * corner(i, j + 1) + fu * corner(i + 1, j + 1));
  };
  return std::max(0.0, sum(x1, y1) - sum(x0, y1) - sum(x1, y0) + sum(x0, y0));
}

PartWork WorkEstimate::of(const PixelRect& rect) const {
  PartWork part;
  part.seconds = (1 - painted_) *
                 within(rect.x0 - around_.x, rect.y0 - around_.y, rect.x1 + around_.x, rect.y1 + around_.y);
  part.inside = within(rect.x0, rect.y0, rect.x1, rect.y1);
  part.painted = painted_ * part.inside;
  part.seconds += part.painted;
  const int left = std::max(0, int((rect.x0 - around_.x) / cell_.x)),
            right = std::min(columns_ - 1, int((rect.x1 - 1 + around_.x) / cell_.x)),
            top = std::max(0, int((rect.y0 - around_.y) / cell_.y)),
            bottom = std::min(rows_ - 1, int((rect.y1 - 1 + around_.y) / cell_.y));
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x)
      part.layers |= seen_[std::size_t(y) * std::size_t(columns_) + std::size_t(x)];
  return part;
}

}  // namespace ringsplat

#include "sheet_engine/sheet_rays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

#include "ringsplat/base/error.hpp"
#include "sheet_engine/sheet_light.hpp"

namespace ringsplat {

namespace {

struct Axes {
  int u, v, k;
};
Axes axes_of(const FrameGeometry& g) {
  const auto [u, v] = in_plane(g.traversal.axis);
  return {u, v, static_cast<int>(g.traversal.axis)};
}

void check_reach(const FrameGeometry& g, double voxels, const char* what_else) {
  if (!(voxels < most_voxels))
    throw InputError(fmt::format("seen along the rays, the {} slices span {:.0f} voxels, more than {:.0f}",
                                 name(g.traversal.axis), voxels, most_voxels),
                     what_else);
}

SheetRays parallel_rays(const FrameGeometry& g) {
  const auto [u, v, k] = axes_of(g);
  const glm::dmat2 to_lattice =
      glm::inverse(glm::dmat2(glm::dvec2(g.view.linear[u]), glm::dvec2(g.view.linear[v])));
  const glm::dvec2 origin = to_lattice * (glm::dvec2(0.5) - glm::dvec2(g.view.offset)),
                   shear = to_lattice * glm::dvec2(g.view.linear[k]);
  SheetRays rays;
  rays.voxels[0] = g.grid.dims[u];
  rays.voxels[1] = g.grid.dims[v];
  rays.patches = true;
  for (int i = 0; i < 2; ++i) {
    check_reach(g, rays.voxels[i] + std::abs(shear[i]) * g.slices,
                "use --engine splats, --undersample, or another view");
    constexpr double unit = double(std::int64_t{1} << 40), most_seen = 1 << 22;
    const double seen =
        std::abs(origin[i]) + g.width * std::abs(to_lattice[0][i]) + g.height * std::abs(to_lattice[1][i]);
    if (!(seen < most_seen))
      throw InputError(
          fmt::format("the picture shows {:.3g} voxels around a volume of {}", seen, rays.voxels[i]),
          "use a larger --zoom");
    const auto fixed = [](double x) { return static_cast<std::int64_t>(std::llround(x * unit)); };
    rays.grid.origin[i] = fixed(origin[i]);
    rays.grid.step_x[i] = fixed(to_lattice[0][i]);
    rays.grid.step_y[i] = fixed(to_lattice[1][i]);
    rays.shear[i] = shear[i];
    const double tile = (tile_side - 1) * (std::abs(to_lattice[0][i]) + std::abs(to_lattice[1][i]));
    rays.patches = rays.patches && tile + std::abs(shear[i]) < patch_span;
  }
  return rays;
}

/// The largest slope of rays in front of the eye, over a picture whose corners are all there.
double steepest_in_picture(const EyeGrid& eye, int i, int width, int height) {
  double steepest = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const double x = (corner & 1) * (width - 1), y = (corner >> 1) * (height - 1);
    if (!(eye.depth(x, y) > 0)) return INFINITY;
    steepest = std::max(steepest, std::abs(eye.slope(i, x, y)));
  }
  return steepest;
}

/// The rays, but for what bounds them.
EyeGrid make_eye_grid(const FrameGeometry& g) {
  const auto [u, v, k] = axes_of(g);
  const int axes[] = {u, v};
  const glm::dvec3 middle = 0.5 * glm::dvec3(g.grid.dims - 1), centre = g.view.project(middle),
                   eye = g.view.project(*g.view.eye), central = middle - *g.view.eye;
  // A pixel's ray goes through the point at the central one's depth that it shows. There, a pixel is so
  // large.
  const double larger = (centre.z - eye.z) / -eye.z;
  const glm::dmat3 to_lattice = larger * glm::inverse(g.view.linear);
  const glm::dvec2 seen = g.view.seen_at(middle) - 0.5;
  EyeGrid grid;
  grid.central_x = float(seen.x);
  grid.central_y = float(seen.y);
  const double to_middle = central[k];
  grid.to_middle = float(to_middle);
  grid.way = g.traversal.ascending ? 1 : -1;
  grid.half_slices = 0.5F * float(g.slices);
  grid.depth_x = float(to_lattice[0][k] / to_middle);
  grid.depth_y = float(to_lattice[1][k] / to_middle);
  for (int i = 0; i < 2; ++i) {
    const double slope = central[axes[i]] / to_middle;
    grid.central_slope[i] = float(slope);
    grid.central_middle[i] = float(middle[axes[i]]);
    grid.slope_x[i] = float((to_lattice[0][axes[i]] - slope * to_lattice[0][k]) / to_middle);
    grid.slope_y[i] = float((to_lattice[1][axes[i]] - slope * to_lattice[1][k]) / to_middle);
  }
  return grid;
}

SheetRays rays_from_eye(const SheetFrame& frame) {
  const FrameGeometry& g = frame.geometry;
  const auto [u, v, k] = axes_of(g);
  const int axes[] = {u, v};
  SheetRays rays;
  EyeGrid& eye = rays.eye.emplace(make_eye_grid(g));
  const double half_slices = 0.5 * g.slices, to_volume = std::abs(double(eye.to_middle)) - half_slices;
  for (int i = 0; i < 2; ++i) {
    const int voxels = rays.voxels[i] = g.grid.dims[axes[i]];
    const double at = (*g.view.eye)[axes[i]],
                 widest = std::max(std::abs(at + 0.5), std::abs(voxels - 0.5 - at));
    const double steepest = std::min(widest / to_volume, steepest_in_picture(eye, i, g.width, g.height)),
                 reach = steepest * half_slices;
    check_reach(g, voxels + 2 * reach, "use a larger --distance, --undersample, or another view");
    eye.steepest[i] = float(steepest * (1 + 1e-6));
    eye.low[i] = float(-1 - reach);
    eye.high[i] = float(voxels + reach);
  }
  set_lengths(frame, eye);
  return rays;
}

}  // namespace

SheetRays make_sheet_rays(const SheetFrame& frame) {
  return frame.geometry.view.eye ? rays_from_eye(frame) : parallel_rays(frame.geometry);
}

SheetSlab make_slab(const SheetFrame& frame, const SheetRays& rays, int step) {
  const int slices = frame.geometry.slices;
  SheetSlab slab;
  slab.step = step + 1;
  slab.face = step < 0 || step == slices - 1;
  slab.pieces = slab.face ? frame.slabs_in_half() : frame.slabs();
  const double way = frame.geometry.traversal.ascending ? 1 : -1;
  const double front = step < 0 ? frame.slice_at(0) - 0.5 * way : frame.slice_at(step);
  const double length = slab.face ? 0.5 : 1;
  for (int i = 0; i <= slab.pieces; ++i) {
    const double at = front + way * length * i / slab.pieces;
    slab.shift_u[std::size_t(i)] = fixed_position(rays.shear[0] * at);
    slab.shift_v[std::size_t(i)] = fixed_position(rays.shear[1] * at);
    slab.slice[std::size_t(i)] = static_cast<float>(at - 0.5 * (slices - 1));
  }
  return slab;
}

}  // namespace ringsplat

#include "sheet_engine/sheet_rays.hpp"

#include <cmath>
#include <glm/matrix.hpp>

namespace ringsplat {

double EyeGrid::depth(double x, double y) const {
  return 1 + double(depth_x) * (x - double(central_x)) + double(depth_y) * (y - double(central_y));
}

double EyeGrid::slope(int i, double x, double y) const {
  return double(central_slope[i]) +
         (double(slope_x[i]) * (x - double(central_x)) + double(slope_y[i]) * (y - double(central_y))) /
             depth(x, y);
}

bool EyeGrid::spans_less(int x, int y, int side, int tile, double voxels) const {
  const double farthest = std::abs(double(to_middle)) + double(half_slices);
  double nearest = INFINITY, change[2] = {}, steep[2] = {};
  // Over a rectangle of pixels in front of the eye, depth and the numerators of slopes' derivatives are
  // linear and slopes are quotients of linear functions, so corners are their extremes.
  for (int corner = 0; corner < 4; ++corner) {
    const double px = x + (corner & 1) * (side - 1), py = y + (corner >> 1) * (side - 1),
                 here = depth(px, py);
    nearest = std::min(nearest, here);
    for (int i = 0; i < 2; ++i) {
      const double from_central = slope(i, px, py) - double(central_slope[i]);
      change[i] =
          std::max(change[i], std::abs(here * (double(slope_x[i]) - from_central * double(depth_x))) +
                                  std::abs(here * (double(slope_y[i]) - from_central * double(depth_y))));
      steep[i] = std::max(steep[i], std::abs(slope(i, px, py)));
    }
  }
  if (!(nearest > 0)) return false;
  for (int i = 0; i < 2; ++i) {
    const double pixel = change[i] / (nearest * nearest) * farthest;
    if (!((tile - 1) * pixel + steep[i] + 2 * double(position_error) < voxels)) return false;
  }
  return true;
}

namespace {

/// u, v and k, the traversed one.
glm::ivec3 axes_of(const FrameGeometry& g) {
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
  const glm::ivec3 axes = axes_of(g);
  const glm::dmat2 to_lattice =
      glm::inverse(glm::dmat2(glm::dvec2(g.view.linear[axes.x]), glm::dvec2(g.view.linear[axes.y])));
  const glm::dvec2 origin = to_lattice * (glm::dvec2(0.5) - glm::dvec2(g.view.offset)),
                   shear = to_lattice * glm::dvec2(g.view.linear[axes.z]);
  SheetRays rays;
  rays.patches = true;
  for (int i = 0; i < 2; ++i) {
    rays.voxels[i] = g.grid.dims[axes[i]];
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
    // Rays in a face, up to what is rounded, are all on one side of it: inside of low ones.
    constexpr double in_face = 1.0 / (1 << 28);
    rays.grid.origin[i] = fixed(origin[i] + in_face);
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
  const glm::ivec3 axes = axes_of(g);
  const int k = axes.z;
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

/// Orthonormal coordinates of the world in which gradients are an upper triangle times differences along u, v
/// and the traversed axis, in front to back order.
struct GradientAxes {
  glm::dvec3 basis[3];
  double upper[3][3] = {};
};

GradientAxes gradient_axes(const FrameGeometry& g) {
  const Grid& grid = g.grid;
  const glm::dmat3 inverse = glm::inverse(grid.direction);
  const double smallest = grid.unit_length();
  const glm::ivec3 axes = axes_of(g);
  // A gradient is a covector: it is mapped to the world by the inverse transpose. Surfaces face away from
  // higher values.
  glm::dvec3 world[3];
  for (int i = 0; i < 3; ++i) {
    const int k = axes[i];
    world[i] = -(smallest / grid.spacing[k]) * glm::dvec3(inverse[0][k], inverse[1][k], inverse[2][k]);
  }
  if (!g.traversal.ascending) world[2] = -world[2];

  // Gram and Schmidt: world = basis · upper triangle.
  GradientAxes to;
  for (int i = 0; i < 3; ++i) {
    glm::dvec3 rest = world[i];
    for (int k = 0; k < i; ++k) {
      to.upper[k][i] = glm::dot(to.basis[k], world[i]);
      rest -= to.upper[k][i] * to.basis[k];
    }
    to.upper[i][i] = glm::length(rest);
    to.basis[i] = rest / to.upper[i][i];
  }
  return to;
}

SheetRays rays_from_eye(const SheetFrame& frame) {
  const FrameGeometry& g = frame.geometry;
  const glm::ivec3 axes = axes_of(g);
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
  // Lengths, and gradient_light()'s coordinates.
  const GradientAxes world = gradient_axes(g);
  const double unit = frame.unit_length();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      eye.axes[i][k] = static_cast<float>(
          glm::dot(world.basis[i], g.grid.direction[axes[k]] * (g.grid.spacing[axes[k]] / unit)));
  eye.table_length = frame.by_length() ? static_cast<float>(frame.step_length()) : 0;
  return rays;
}

}  // namespace

GradientLight gradient_light(const SheetFrame& frame, double most, double of_value) {
  const FrameGeometry& g = frame.geometry;
  const auto [basis, upper] = gradient_axes(g);
  const ViewTransform& view = g.view;
  const Shown& shown = frame.shown;
  const glm::dvec3 to_light =
      glm::normalize(view.right * shown.light.x + view.up * shown.light.y + view.to_viewer * shown.light.z);
  const double scale = most > 0 ? 1 / most : 1;
  const auto scaled = [scale](double x) { return static_cast<float>(x * scale); };
  GradientLight light;
  light.uu = scaled(upper[0][0]);
  light.uv = scaled(upper[0][1]);
  light.uk = scaled(upper[0][2]);
  light.vv = scaled(upper[1][1]);
  light.vk = scaled(upper[1][2]);
  light.kk = scaled(upper[2][2]);
  if (shown.edges) {
    // Differences are over two voxels, in smallest spacings.
    const double length = 2 * of_value * g.grid.unit_length();
    light.edges = true;
    light.edge_from = scaled(shown.edges->from * length);
    light.over_edge = 1 / scaled((shown.edges->to - shown.edges->from) * length);
  }
  const auto mixed = [&](int i, int k) { return std::abs(upper[i][k]) > 1e-12 * upper[k][k]; };
  light.oblique = mixed(0, 1) || mixed(0, 2) || mixed(1, 2);
  for (int i = 0; i < 3; ++i) {
    light.light[i] = static_cast<float>(glm::dot(basis[i], to_light));
    light.viewer[i] = static_cast<float>(glm::dot(basis[i], view.to_viewer));
  }
  light.between = static_cast<float>(glm::dot(to_light, view.to_viewer));
  light.ambient = static_cast<float>(shown.material.ambient);
  light.diffuse = static_cast<float>(shown.material.diffuse);
  light.specular = static_cast<float>(shown.material.specular);
  light.exponent = static_cast<float>(shown.material.exponent);
  // Colours as they are.
  if (!frame.shaded()) light.ambient = 1, light.diffuse = light.specular = 0;
  return light;
}

SheetRays make_sheet_rays(const SheetFrame& frame) {
  return frame.geometry.view.eye ? rays_from_eye(frame) : parallel_rays(frame.geometry);
}

SheetPlane make_sheet_plane(const LatticePlane& plane, const FrameGeometry& g) {
  const glm::ivec3 axes = axes_of(g);
  glm::dvec3 middle(0.0);
  middle[axes.z] = 0.5 * (g.slices - 1);
  SheetPlane made{{}, float(plane.before(middle))};
  for (int i = 0; i < 3; ++i) made.along[i] = float(plane.normal[axes[i]]);
  return made;
}

SheetSlab make_slab(const SheetFrame& frame, const SheetRays& rays, int step) {
  const int slices = frame.geometry.slices;
  SheetSlab slab;
  slab.step = step + 1;
  slab.face = step < 0 || step == slices - 1;
  slab.pieces = slab.face ? frame.slabs_in_half() : frame.slabs();
  const double way = frame.geometry.traversal.ascending ? 1 : -1;
  const double front = step < 0 ? frame.geometry.slice_at(0) - 0.5 * way : frame.geometry.slice_at(step);
  const double length = slab.face ? 0.5 : 1;
  const auto fixed = [](double voxels) {
    return static_cast<std::int32_t>(std::floor(voxels * one_voxel + 0.5));
  };
  for (int i = 0; i <= slab.pieces; ++i) {
    const double at = front + way * length * i / slab.pieces;
    slab.shift_u[std::size_t(i)] = fixed(rays.shear[0] * at);
    slab.shift_v[std::size_t(i)] = fixed(rays.shear[1] * at);
    slab.slice[std::size_t(i)] = static_cast<float>(at - 0.5 * (slices - 1));
  }
  return slab;
}

}  // namespace ringsplat

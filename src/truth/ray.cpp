#include "truth/ray.hpp"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace ringsplat::truth {

LatticeFrame lattice_of(const Grid& grid) { return {grid.dims, grid.spacing, grid.origin, grid.direction}; }

ViewTransform view_of(const Scene& scene) {
  if (!scene.cut_from)
    return make_view(scene.frame.shown.camera, lattice_of(scene.grid), scene.frame.shown.width,
                     scene.frame.shown.height);
  ViewTransform view = make_view(scene.frame.shown.camera, scene.cut_from->whole, scene.frame.shown.width,
                                 scene.frame.shown.height);
  const glm::dvec3 first(scene.cut_from->first);
  view.offset += view.linear * first;
  if (view.eye) *view.eye -= first;
  return view;
}

LatticeBox voxel_faces(const Scene& scene) {
  const VoxelBox shown = scene.frame.shown.clip.value_or(VoxelBox{glm::ivec3(0), scene.grid.dims});
  return {glm::dvec3(shown.first) - 0.5, glm::dvec3(shown.end) - 0.5};
}

double CutPlane::at(const glm::dvec3& place) const { return glm::dot(normal, place) + offset; }

Rays::Rays(const Scene& scene, const LatticeBox& box) : scene_(&scene), view_(view_of(scene)), box_(box) {
  to_lattice_ = glm::inverse(view_.linear);
  const LatticeFrame whole = scene.cut_from ? scene.cut_from->whole : lattice_of(scene.grid);
  const glm::dvec3 first(scene.cut_from ? scene.cut_from->first : glm::ivec3(0));
  for (const auto& [normal, distance] : scene.frame.shown.clip_planes) {
    const glm::dvec3 from_middle =
        whole.direction * (whole.spacing * (first - 0.5 * glm::dvec3(whole.dims - 1)));
    const glm::dvec3 unit = glm::normalize(normal);
    planes_.push_back(
        {glm::transpose(whole.direction) * unit * whole.spacing, glm::dot(unit, from_middle) - distance});
  }
  if (view_.eye) return;
  point(parallel_, to_lattice_ * glm::dvec3(0, 0, 1));
  parallel_.to_viewer = view_.to_viewer;
}

void Rays::point(LatticeRay& ray, const glm::dvec3& steps) const {
  const Grid& grid = scene_->grid;
  const glm::dvec3 world = grid.direction * (grid.spacing / grid.unit_length() * steps);
  ray.step = steps / glm::length(world);
  ray.to_viewer = -glm::normalize(world);
}

LatticeRay Rays::through(Pixel pixel) const {
  LatticeRay ray = parallel_;
  ray.origin = to_lattice_ * (glm::dvec3(pixel.x + 0.5, pixel.y + 0.5, 0) - view_.offset);
  if (view_.eye) point(ray, ray.origin - *view_.eye);
  // s counts from the point nearest to the volume's middle, so that it is not a difference of large numbers.
  const glm::dvec3 middle = 0.5 * (box_.low + box_.high);
  const glm::dvec3& step = ray.step;
  const double nearest = glm::dot(middle - ray.origin, step) / glm::dot(step, step);
  ray.origin += nearest * step;
  ray.enter = view_.eye ? glm::dot(*view_.eye - ray.origin, step) / glm::dot(step, step)
                        : -std::numeric_limits<double>::infinity();
  ray.leave = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    constexpr double parallel = 1e-12;
    const double shift = std::abs(step[k]) < parallel ? in_face : 0, low = box_.low[k] - shift,
                 high = box_.high[k] - shift;
    if (step[k] == 0) {
      if (ray.origin[k] >= low && ray.origin[k] < high) continue;
      ray.enter = ray.leave = 0;  // beside the box all the way
      return ray;
    }
    const double s0 = (low - ray.origin[k]) / step[k], s1 = (high - ray.origin[k]) / step[k];
    ray.enter = std::max(ray.enter, std::min(s0, s1));
    ray.leave = std::min(ray.leave, std::max(s0, s1));
  }
  for (const CutPlane& plane : planes_) {
    const double here = plane.at(ray.origin), rise = glm::dot(plane.normal, step);
    if (rise > 0) ray.enter = std::max(ray.enter, -here / rise);
    if (rise < 0) ray.leave = std::min(ray.leave, -here / rise);
    if (rise == 0 && here < 0) ray.leave = ray.enter;
  }
  return ray;
}

bool Rays::hit(Pixel pixel) const {
  const LatticeRay ray = through(pixel);
  return ray.enter < ray.leave;
}

ScreenBounds Rays::bounds() const {
  ScreenBounds bounds;
  bounds.rows.resize(std::size_t(scene_->frame.shown.height));
  // A box's picture is convex, so each row has one piece of it.
  parallel_for(bounds.rows.size(), 16, [&](std::size_t from, std::size_t to) {
    for (std::size_t y = from; y < to; ++y) {
      ScreenBounds::Row row{0, scene_->frame.shown.width};
      while (row.first < row.end && !hit({row.first, int(y)})) ++row.first;
      while (row.first < row.end && !hit({row.end - 1, int(y)})) --row.end;
      bounds.rows[y] = row;
    }
  });
  return bounds;
}

std::vector<Cut> cuts_along(const Scene& scene, const LatticeRay& ray) {
  std::vector<Cut> cuts{{ray.enter}, {ray.leave}};
  const glm::dvec3 first = ray.at(ray.enter), last = ray.at(ray.leave);
  for (int k = 0; k < 3; ++k) {
    if (ray.step[k] == 0) continue;
    const double in_voxel = scene.nearest() || !scene.labels.empty() ? 2 : 1;
    const double low = std::ceil(in_voxel * std::min(first[k], last[k])),
                 high = std::floor(in_voxel * std::max(first[k], last[k]));
    for (double plane = low; plane <= high; ++plane) {
      const double s = (plane / in_voxel - ray.origin[k]) / ray.step[k];
      if (s > ray.enter && s < ray.leave) cuts.push_back({s, k});
    }
  }
  std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.at < b.at; });
  return cuts;
}

Crossing crossing_between(const Scene& scene, const LatticeRay& ray, double enter, double leave) {
  const glm::dvec3 middle = ray.at(0.5 * (enter + leave));
  const glm::ivec3 corner(glm::floor(middle)), last = scene.grid.dims - 1,
                                               nearest = nearest_voxel(middle, scene.grid.dims);
  const Cell cell{glm::clamp(corner, glm::ivec3(0), last), glm::clamp(corner + 1, glm::ivec3(0), last)};
  return {enter, leave, corner, nearest, cell, scene.nearest() ? Cell{nearest, nearest} : cell};
}

}  // namespace ringsplat::truth

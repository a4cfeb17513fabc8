#include "truth/passage.hpp"

namespace ringsplat::truth {
namespace {

/// Where a ray enters or leaves the volume, through one of its faces or from the eye.
Uncertain end_of(const Scene& scene, const LatticeRay& ray, double at) {
  Uncertain end{at, tube};
  const LatticeBox box = voxel_faces(scene);
  for (int k = 0; k < 3; ++k)
    for (const double face : {box.low[k], box.high[k]}) {
      const double by = tube / std::abs(ray.step[k]);
      if (std::abs((face - ray.origin[k]) / ray.step[k] - at) < 2 * by) end.by = std::max(end.by, by);
    }
  return end;
}

/// A ray's height above a clip plane, and how it changes along the ray.
struct Height {
  double of_voxel;  ///< how much a voxel's length along each axis changes it, at most
  Interval here, rise = 0;
};
Height height_above(const CutPlane& plane, const LatticeRay& ray) {
  const glm::dvec3 n = glm::abs(plane.normal);
  const double of_voxel = n.x + n.y + n.z;
  // The plane is as uncertain as the ray.
  Height height{of_voxel, plane.offset + within(2 * tube * of_voxel)};
  for (int k = 0; k < 3; ++k) {
    height.here += Interval(plane.normal[k]) * ray.origin[k];
    height.rise += Interval(plane.normal[k]) * ray.step[k];
  }
  return height;
}

}  // namespace

std::optional<Uncertain> plane_crossing(const LatticeRay& ray, const CutPlane& plane) {
  const auto [of_voxel, here, rise] = height_above(plane, ray);
  if (may_run_along_faces(std::min(std::abs(rise.lower()), std::abs(rise.upper())) / of_voxel))
    return std::nullopt;
  const Interval at = -here / rise;
  return Uncertain{median(at), OutwardRounding::up(0.5 * width(at)),
                   rise.lower() > 0 ? Uncertain::CutsOff::before : Uncertain::CutsOff::behind};
}

Way way_along(const Scene& scene, const LatticeRay& ray, std::span<const CutPlane> planes) {
  Way way;
  std::vector<Uncertain>& cuts = way.cuts;
  for (const auto& [at, axis] : cuts_along(scene, ray)) {
    if (!axis)
      cuts.push_back(end_of(scene, ray, at));
    else
      cuts.push_back({at, may_run_along_faces(ray.step[*axis]) ? 0 : tube / std::abs(ray.step[*axis])});
  }
  const Interval whole = hull(cuts.front().exact(), cuts.back().exact());
  for (const CutPlane& plane : planes) {
    const Height height = height_above(plane, ray);
    const Interval all = height.here + height.rise * whole;
    if (all.upper() < 0) return {};
    if (all.lower() > 0) continue;
    if (const auto cut = plane_crossing(ray, plane))
      cuts.insert(std::ranges::upper_bound(cuts, cut->at, {}, &Uncertain::at), *cut);
    else
      way.along_plane = true;
  }
  // Of three planes at one place as well, and of clip planes, each may be crossed first.
  for (std::size_t round = 0; round < 2 + planes.size(); ++round)
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      Uncertain &one = cuts[i], &next = cuts[i + 1];
      const double apart = next.at - one.at, by = apart + one.by + next.by;
      const bool may_change_places = (one.by > 0 && next.by > 0) || !planes.empty();
      if (may_change_places && apart <= one.by + next.by) one.by = next.by = by;
    }
  way.enter = cuts.front();
  way.leave = cuts.back();
  for (const Uncertain& cut : cuts) {
    if (cut.cuts_off == Uncertain::CutsOff::before) way.enter = cut;
    if (cut.cuts_off == Uncertain::CutsOff::behind && cut.at < way.leave.at) way.leave = cut;
  }
  return way;
}

Passage passage_between(const Scene& scene, const LatticeRay& ray, const Uncertain& enter,
                        const Uncertain& leave) {
  const Interval length = leave.exact() - enter.exact();
  Passage p{crossing_between(scene, ray, enter.at, leave.at),
            {std::max(0.0, length.lower()), length.upper()},
            {},
            {}};
  for (int k = 0; k < 3; ++k) {
    const auto axis = std::size_t(k);
    const auto place = [&](const Uncertain& cut) {
      const Interval exact =
          Interval(ray.origin[k]) + cut.exact() * ray.step[k] + within(tube) - double(p.corner[k]);
      if (may_run_along_faces(ray.step[k]))
        p.beside = std::max({p.beside, -exact.lower(), exact.upper() - 1});
      return clamped(exact, 0, 1);
    };
    p.from[axis] = place(enter);
    p.change[axis] = place(leave) - p.from[axis];
  }
  return p;
}

Polynomial along_passage(const Corners<Ball>& corners, const Passage& passage) {
  std::array<Polynomial, 8> level{};
  for (std::size_t c = 0; c < 8; ++c) level[c][0] = corners[c];
  for (std::size_t axis = 0, count = 8; axis < 3; ++axis, count /= 2)
    for (std::size_t c = 0; c < count / 2; ++c) {
      Polynomial mixed = level[2 * c];
      for (std::size_t k = 0; k < 4; ++k) {
        const Ball apart = level[2 * c + 1][k] - level[2 * c][k];
        mixed[k] = with_product(mixed[k], apart, passage.from[axis]);
        if (k < 3) mixed[k + 1] = with_product(mixed[k + 1], apart, passage.change[axis]);
      }
      level[c] = mixed;
    }
  return level[0];
}

}  // namespace ringsplat::truth

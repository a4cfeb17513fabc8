#include "truth/passage.hpp"

#include <algorithm>

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

}  // namespace

std::vector<Uncertain> uncertain_cuts(const Scene& scene, const LatticeRay& ray) {
  std::vector<Uncertain> cuts;
  for (const auto& [at, axis] : cuts_along(scene, ray)) {
    if (!axis)
      cuts.push_back(end_of(scene, ray, at));
    else
      cuts.push_back({at, may_run_along_faces(ray.step[*axis]) ? 0 : tube / std::abs(ray.step[*axis])});
  }
  // Of three planes at one place as well, each may be crossed first.
  for (int round = 0; round < 2; ++round)
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      Uncertain &one = cuts[i], &next = cuts[i + 1];
      const double apart = next.at - one.at, by = apart + one.by + next.by;
      if (one.by > 0 && next.by > 0 && apart <= one.by + next.by) one.by = next.by = by;
    }
  return cuts;
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

Polynomial along_passage(const Corners<Interval>& corners, const Passage& passage) {
  std::array<Polynomial, 8> level{};
  for (std::size_t c = 0; c < 8; ++c) level[c][0] = corners[c];
  for (std::size_t axis = 0, count = 8; axis < 3; ++axis, count /= 2)
    for (std::size_t c = 0; c < count / 2; ++c) {
      Polynomial mixed = level[2 * c];
      for (std::size_t k = 0; k < 4; ++k) {
        const Interval apart = level[2 * c + 1][k] - level[2 * c][k];
        mixed[k] += apart * passage.from[axis];
        if (k < 3) mixed[k + 1] += apart * passage.change[axis];
      }
      level[c] = mixed;
    }
  return level[0];
}

}  // namespace ringsplat::truth

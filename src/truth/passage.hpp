#pragma once
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "truth/ray.hpp"
#include "truth/series.hpp"

namespace ringsplat::truth {

/// A ray that is computed in doubles lies this near to the exact one, in voxels (docs/certified.md, 1).
inline constexpr double tube = 1e-10;

/// So slow along an axis, a ray may run along voxels' faces: where it crosses them is not known.
inline bool may_run_along_faces(double step) {
  constexpr double slowest = 1e-5;
  return std::abs(step) < slowest;
}

/// A place along a ray, and how uncertain it is.
struct Uncertain {
  double at, by;
  enum class CutsOff { nothing, before, behind } cuts_off = CutsOff::nothing;  ///< as a clip plane
  Interval exact() const { return Interval(at) + within(by); }
  bool surely_before(const Uncertain& other) const { return exact().upper() < other.exact().lower(); }
};

/// Where a ray through the whole box crosses planes between voxels and clip planes, and enters and leaves the
/// volume (docs/certified.md, 2 and 10).
struct Way {
  std::vector<Uncertain> cuts = {};    ///< ascending; none where clip planes surely leave nothing
  bool along_plane = false;            ///< may run along a clip plane, on either side of it
  Uncertain enter{0, 0}, leave{0, 0};  ///< of what clip planes leave
  /// Of two neighbouring cuts: whether clip planes surely leave nothing between them.
  bool is_cut_off(const Uncertain& from, const Uncertain& to) const {
    return (to.at <= enter.at && from.surely_before(enter)) ||
           (from.at >= leave.at && leave.surely_before(to));
  }
};
Way way_along(const Scene& scene, const LatticeRay& ray, std::span<const CutPlane> planes);

/// Where a ray crosses a clip plane; nothing where it may run along it.
std::optional<Uncertain> plane_crossing(const LatticeRay& ray, const CutPlane& plane);

/// A crossing, with what is known of the exact ray's.
struct Passage : Crossing {
  Interval length;                       ///< of the exact ray's passage, from 0
  std::array<Interval, 3> from, change;  ///< place in the cell, 0 to 1 along each axis, and along the passage
  double beside = 0;                     ///< how far the exact ray may be outside of it
};

Passage passage_between(const Scene& scene, const LatticeRay& ray, const Uncertain& enter,
                        const Uncertain& leave);

/// Interpolation between a cell's corners as a polynomial of the part of the passage.
Polynomial along_passage(const Corners<Ball>& corners, const Passage& passage);

}  // namespace ringsplat::truth

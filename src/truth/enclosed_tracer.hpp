#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "truth/certified.hpp"
#include "truth/enclosed_piece.hpp"
#include "truth/passage.hpp"
#include "truth/ray.hpp"

namespace ringsplat::truth {

/// What proofs along a scene's rays stand on.
class EnclosedTracer : protected Tracer {
 protected:
  explicit EnclosedTracer(const Scene& scene)
      : Tracer(scene),
        lines_(curve_),
        gradients_(scene),
        whole_(rays_.uncut()),
        grown_(Rays(scene, resized(tube)).uncut()),
        shrunk_(Rays(scene, resized(-tube)).uncut()) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double v : scene.values) {
      const double finite = curve_.bounded(v);
      if (std::isnan(finite)) continue;
      low = std::min(low, finite);
      high = std::max(high, finite);
    }
    if (low <= high) values_ = {low, high};
    const glm::dmat3 to_world = against_gradient(scene.grid.direction, scene.grid.spacing);
    constexpr double largest_difference = 2;  // of values that Gradients scales to at most 1
    for (int k = 0; k < 3; ++k)
      for (int row = 0; row < 3; ++row) steepest_ += 2 * largest_difference * std::abs(to_world[k][row]);
  }

  /// Of a pixel: what see(ray, way) finds, or nothing where the exact ray may miss what is shown.
  template <class See>
  PixelBounds seen_by(Pixel pixel, const See& see) const {
    const PixelBounds nothing{Rgba(0.0), Rgba(0.0)};
    const LatticeRay ray = whole_.through(pixel);
    if (!(ray.enter < ray.leave)) return grown_.hit(pixel) ? PixelBounds{} : nothing;
    const Way way = way_along(scene_, ray, rays_.planes());
    if (way.cuts.empty() || way.leave.surely_before(way.enter)) return nothing;
    if (way.along_plane) return {};
    PixelBounds bounds = bounds_of(see(ray, way));
    if (!shrunk_.hit(pixel) || !way.enter.surely_before(way.leave)) bounds.low = Rgba(0.0);
    return bounds;
  }

  /// Calls see(passage) for what clip planes may leave of a ray, from its front until that returns false.
  template <class See>
  void for_passages(const LatticeRay& ray, const Way& way, const See& see) const {
    for (std::size_t i = 0; i + 1 < way.cuts.size(); ++i)
      if (!way.is_cut_off(way.cuts[i], way.cuts[i + 1]) &&
          !see(passage_between(scene_, ray, way.cuts[i], way.cuts[i + 1])))
        return;
  }

  /// Where a ray runs along a face, or along an edge, what is on the other side counts as well.
  bool beside_other_medium(const LatticeRay& ray, const Passage& passage) const {
    if (!scene_.nearest() && passage.beside > 0 && !values_around(passage)) return true;
    if (!scene_.nearest() && !(tints_.any() && beside_other_tint(passage))) return false;
    for (int k = 0; k < 3; ++k) {
      if (!may_run_along_faces(ray.step[k])) continue;
      for (const double s : {passage.enter, passage.leave}) {
        constexpr double towards_greater = 1e-9;  // as nearest_voxel() rounds
        const double place = ray.at(s)[k] + 0.5 + towards_greater - passage.voxel[k];
        if (!(place > tube && place < 1 - tube)) return true;
      }
    }
    return false;
  }

  /// Calls see(voxel) for all that a ray beside the passage's cell may see.
  template <class See>
  void for_voxels_around(const Passage& passage, const See& see) const {
    const glm::ivec3 first = glm::max(passage.cell.low - 1, 0),
                     last = glm::min(passage.cell.high + 1, scene_.grid.dims - 1);
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) see(glm::ivec3(x, y, z));
  }
  /// The values there; nothing where one is no number.
  std::optional<Interval> values_around(const Passage& passage) const {
    Interval all = Interval::empty();
    bool complete = true;
    for_voxels_around(passage, [&](const glm::ivec3& voxel) {
      const double v = curve_.bounded(scene_.values[scene_.index(voxel)]);
      complete = complete && !std::isnan(v);
      if (!std::isnan(v)) all = hull(all, Interval(v));
    });
    return complete ? std::optional(all) : std::nullopt;
  }
  bool beside_other_tint(const Passage& passage) const {
    bool other = false;
    for_voxels_around(passage, [&](const glm::ivec3& voxel) {
      other = other || tints_.of(voxel) != tints_.of(passage.voxel);
    });
    return other;
  }

  /// Those of a passage of which only what is near it is known; nothing where it may have none.
  std::optional<Interval> values_near(const LatticeRay& ray, const Passage& passage) const {
    const auto around = values_around(passage);
    if (!around || scene_.nearest()) return around;
    // What it crosses at most, in the cell or in those beside.
    const glm::dvec3 step = glm::abs(ray.step);
    const double voxels = passage.length.upper() * std::max({step.x, step.y, step.z}) + tube;
    const Interval of_cell =
        series_of<0>(about(value_of(*cell_values(scene_, curve_, passage.cell), passage), 0.5), 0.5)[0];
    return clamped(of_cell + within(3 * voxels * width(values_)), around->lower(), around->upper());
  }

  /// How far the field is from the cell's own: each axis changes it by less than the values' range a voxel.
  double off_cell(const Passage& passage) const {
    return passage.beside > 0 ? 3 * passage.beside * width(values_) : 0;
  }

  Polynomial value_of(const CellValues& values, const Passage& passage) const {
    if (values.low == values.high) return {values.low};
    Corners<Ball> corners;
    std::copy(values.corners.begin(), values.corners.end(), corners.begin());
    return along_passage(corners, passage);
  }

  CellMedium medium_of(const LatticeRay& ray, const Passage& passage, const CellValues& values,
                       double extra) const {
    CellMedium medium{value_of(values, passage), {}, std::nullopt, passage.length, tints_.of(passage.voxel)};
    if (extra > 0) medium.value[0] = medium.value[0] + Ball(0, extra);
    if (!scene_.needs_gradients()) return medium;
    const Corners<glm::dvec3> normals = cell_normals(gradients_, passage.cell);
    const bool level = std::ranges::all_of(normals, [](const glm::dvec3& n) { return n == glm::dvec3(0.0); });
    for (int k = 0; k < 3; ++k) {
      Corners<Ball> corners;
      for (std::size_t c = 0; c < 8; ++c) {
        constexpr double rounding = 1e-14;
        corners[c] = {normals[c][k], rounding * glm::length(normals[c])};
      }
      medium.normal[std::size_t(k)] = along_passage(corners, passage);
      Ball& first = medium.normal[std::size_t(k)][0];
      first = first + Ball(0, 3 * passage.beside * steepest_);
    }
    if (const auto& edges = shown_.edges) medium.edge.emplace(*edges, gradients_.unit());
    if (scene_.shaded() && !(level && passage.beside == 0))
      medium.light.emplace(shown_.material, phong_.to_light(), ray.to_viewer);
    return medium;
  }

  EnclosedCurve lines_;
  Gradients gradients_;
  Rays whole_, grown_, shrunk_;  ///< without clip planes
  Interval values_ = 0;          ///< of all voxels that are numbers
  double steepest_ = 0;          ///< how much a normal's component changes from voxel to voxel, at most

  LatticeBox resized(double by) const {
    const LatticeBox box = voxel_faces(scene_);
    return {box.low - by, box.high + by};
  }

  static PixelBounds bounds_of(const EnclosedPiece& seen) {
    const auto& [red, green, blue] = seen.colour;
    const Interval channels[] = {red, green, blue, clamped(1.0 - seen.transmittance, 0, 1)};
    PixelBounds bounds;
    for (int c = 0; c < 4; ++c) {
      bounds.low[c] = channels[c].lower();
      bounds.high[c] = channels[c].upper();
      // Whatever was no number proves nothing.
      if (!(bounds.low[c] <= bounds.high[c])) return {};
    }
    return bounds;
  }
};

}  // namespace ringsplat::truth

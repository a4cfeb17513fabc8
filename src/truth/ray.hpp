#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "truth/parallel.hpp"
#include "truth/scene.hpp"

namespace ringsplat::truth {

LatticeFrame lattice_of(const Grid& grid);
/// The view from the scene's lattice to the screen.
ViewTransform view_of(const Scene& scene);

/// A box in lattice coordinates.
struct LatticeBox {
  glm::dvec3 low, high;
};
/// The faces of the voxels that are shown: [−½, n − ½] along each axis without a clip box.
LatticeBox voxel_faces(const Scene& scene);
/// A ray along a face and so near to it, in voxels, lies in it: inside of the voxels' low faces, outside of
/// their high ones. Pixels' centres do where a fitted picture's size is a round number.
inline constexpr double in_face = 1.0 / (1 << 28);

/// A clip plane in lattice coordinates: what is left has normal · place + offset of at least 0.
struct CutPlane {
  glm::dvec3 normal;
  double offset;
  double at(const glm::dvec3& place) const;
};

/// A pixel's ray in lattice coordinates: origin + s · step, s in unit lengths. It enters the box, or what
/// clip planes leave of it, at `enter` and leaves it at `leave`; enter ≥ leave when it misses. A ray from an
/// eye inside the box enters at the eye.
struct LatticeRay {
  glm::dvec3 origin, step;
  glm::dvec3 to_viewer{0.0};  ///< world direction, unit length
  double enter = 0, leave = 0;
  glm::dvec3 at(double s) const { return origin + s * step; }
};

/// The rays of a scene's view through a box: that of the voxels' faces, or another one. The scene must
/// outlive them.
class Rays {
 public:
  explicit Rays(const Scene& scene) : Rays(scene, voxel_faces(scene)) {}
  Rays(const Scene& scene, const LatticeBox& box);
  LatticeRay through(Pixel pixel) const;
  bool hit(Pixel pixel) const;
  /// The pixels whose rays cross the box.
  ScreenBounds bounds() const;
  const ViewTransform& view() const { return view_; }
  const std::vector<CutPlane>& planes() const { return planes_; }
  /// Those through the whole box.
  Rays uncut() const {
    Rays whole = *this;
    whole.planes_.clear();
    return whole;
  }

 private:
  /// Sets the direction of a ray along `steps`, lattice steps of any length.
  void point(LatticeRay& ray, const glm::dvec3& steps) const;

  const Scene* scene_;
  ViewTransform view_;
  LatticeBox box_;
  std::vector<CutPlane> planes_;
  glm::dmat3 to_lattice_{1.0};
  LatticeRay parallel_;  ///< the direction of an orthographic view's rays
};

/// Where a ray enters and leaves the volume (no axis), and where between them it crosses an axis' plane of
/// cells' faces; of nearest voxels' faces as well, where values or tints are not interpolated. Ascending;
/// each is computed from the ray's start.
struct Cut {
  double at;
  std::optional<int> axis = std::nullopt;
};
std::vector<Cut> cuts_along(const Scene& scene, const LatticeRay& ray);

/// What the truths along a scene's rays stand on.
struct Tracer {
  explicit Tracer(const Scene& scene)
      : scene_(scene),
        shown_(scene.frame.shown),
        rays_(scene),
        curve_(shown_.transfer_function),
        phong_(scene, rays_.view()),
        tints_(scene) {}
  /// From slice to slice of an axis along the ray, as it counts: in unit lengths, or one without correction.
  double slice_length(const LatticeRay& ray, int axis) const {
    return shown_.opacity_correction ? 1 / std::abs(ray.step[axis]) : 1.0;
  }
  const Scene& scene_;
  const Shown& shown_;
  Rays rays_;
  TransferCurve curve_;
  Phong phong_;
  Tints tints_;
};

/// along(pixel) of each pixel, on all cores; calls Scene::poll meanwhile.
template <class Along>
auto along_rays(const Scene& scene, std::span<const Pixel> pixels, const Along& along) {
  std::vector<decltype(along(Pixel{}))> colours(pixels.size());
  parallel_for(
      pixels.size(), 16,
      [&](std::size_t first, std::size_t end) {
        for (std::size_t p = first; p < end; ++p) colours[p] = along(pixels[p]);
      },
      scene.poll);
  return colours;
}

/// Extinction of opacity `opacity` per unit length: infinite for 1.
inline double extinction(double opacity) {
  return opacity < 1 ? -std::log1p(-opacity) : std::numeric_limits<double>::infinity();
}

/// What a cell's eight corners have (number 4z + 2y + x), and interpolation between them.
template <class T>
using Corners = std::array<T, 8>;

template <class T>
T trilinear(const Corners<T>& c, const glm::dvec3& f) {
  const auto mix = [](const T& a, const T& b, double t) { return (1 - t) * a + t * b; };
  const T front = mix(mix(c[0], c[1], f.x), mix(c[2], c[3], f.x), f.y);
  const T back = mix(mix(c[4], c[5], f.x), mix(c[6], c[7], f.x), f.y);
  return mix(front, back, f.z);
}

/// The voxels to interpolate between; the same voxel twice where the field does not change along an axis.
struct Cell {
  glm::ivec3 low, high;
  glm::ivec3 corner(int c) const {
    return {(c & 1) ? high.x : low.x, (c & 2) ? high.y : low.y, (c & 4) ? high.z : low.z};
  }
};

/// The voxel nearest to a place. Of two that are equally near it is the one with the greater number, however
/// the place is rounded: rays often run along voxels' faces.
inline glm::ivec3 nearest_voxel(const glm::dvec3& place, const glm::ivec3& dims) {
  constexpr double rounding = 1e-9;
  return glm::clamp(glm::ivec3(glm::floor(place + (0.5 + rounding))), glm::ivec3(0), dims - 1);
}

/// The part of a ray between two neighbouring cuts, which is inside one cell.
struct Crossing {
  double enter, leave;
  glm::ivec3 corner;  ///< the low one; −1 in the half voxel before the first centre
  glm::ivec3 voxel;   ///< the nearest, where cuts are at voxels' faces
  Cell cell;
  Cell shown;  ///< the same, or the voxel whose value it has where values are not interpolated
};
Crossing crossing_between(const Scene& scene, const LatticeRay& ray, double enter, double leave);

struct CellValues {
  Corners<double> corners;
  double low, high;
  /// Never outside [low, high], whatever the rounding.
  double at(const glm::dvec3& f) const { return std::clamp(trilinear(corners, f), low, high); }
};

/// Nothing when a corner is not a number. Infinities become numbers beyond the transfer function's ends.
inline std::optional<CellValues> cell_values(const Scene& scene, const TransferCurve& curve,
                                             const Cell& cell) {
  CellValues values{{}, 1 / 0.0, -1 / 0.0};
  for (int c = 0; c < 8; ++c) {
    const double v = curve.bounded(scene.values[scene.index(cell.corner(c))]);
    if (std::isnan(v)) return std::nullopt;
    values.corners[std::size_t(c)] = v;
    values.low = std::min(values.low, v);
    values.high = std::max(values.high, v);
  }
  return values;
}

inline Corners<glm::dvec3> cell_normals(const Gradients& gradients, const Cell& cell) {
  Corners<glm::dvec3> normals;
  for (int c = 0; c < 8; ++c) normals[std::size_t(c)] = gradients.at(cell.corner(c));
  return normals;
}

}  // namespace ringsplat::truth

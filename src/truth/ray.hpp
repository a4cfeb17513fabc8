#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
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

/// A pixel's ray in lattice coordinates: origin + s · step, s in unit lengths. It enters the box at `enter`
/// and leaves it at `leave`; enter ≥ leave when it misses. A ray from an eye inside the box enters at the
/// eye.
struct LatticeRay {
  glm::dvec3 origin, step;
  glm::dvec3 to_viewer{0.0};  ///< world direction, unit length
  double enter = 0, leave = 0;
  glm::dvec3 at(double s) const { return origin + s * step; }
};

/// The rays of one view through a box: that of the voxels' faces, or another one.
class Rays {
 public:
  explicit Rays(const Scene& scene) : Rays(scene, voxel_faces(scene)) {}
  Rays(const Scene& scene, const LatticeBox& box);
  LatticeRay through(Pixel pixel) const;
  /// The pixels whose rays cross the box.
  ScreenBounds bounds() const;
  const ViewTransform& view() const { return view_; }

 private:
  ViewTransform view_;
  int width_, height_;
  LatticeBox box_;
  /// Sets the direction of a ray along `steps`, lattice steps of any length.
  void point(LatticeRay& ray, const glm::dvec3& steps) const;

  Grid grid_;
  glm::dmat3 to_lattice_{1.0};
  LatticeRay parallel_;  ///< the direction of an orthographic view's rays
};

/// What the truths along a scene's rays stand on.
struct Tracer {
  explicit Tracer(const Scene& scene)
      : scene_(scene),
        rays_(scene),
        curve_(scene.frame.shown.transfer_function),
        phong_(scene, rays_.view()) {}
  const Scene& scene_;
  Rays rays_;
  TransferCurve curve_;
  Phong phong_;
};

/// along(pixel) of each pixel, on all cores; calls Scene::poll meanwhile.
template <class Along>
std::vector<Rgba> along_rays(const Scene& scene, std::span<const Pixel> pixels, const Along& along) {
  std::vector<Rgba> colours(pixels.size());
  parallel_for(
      pixels.size(), 16,
      [&](std::size_t first, std::size_t end) {
        for (std::size_t p = first; p < end; ++p) colours[p] = along(pixels[p]);
      },
      scene.poll);
  return colours;
}

/// Extinction of opacity `opacity` per unit length: infinite for 1.
double extinction(double opacity);

}  // namespace ringsplat::truth

#pragma once
#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>

#include "ringsplat/base/axis.hpp"
#include "ringsplat/view/view.hpp"

namespace ringsplat {

/// Smallest semi-axis of a kernel's ellipse in the image plane, in pixels. With a smaller one a voxel between
/// pixel centres would vanish and flicker (Swan 1997; Zwicker 2001). One pixel is the smallest radius at
/// which the quartic's sum over the pixels stays within 10 % wherever the voxel lies.
inline constexpr double narrowest_half_width = 1.0;

/// The kernel's shape in the image plane, constant over a frame because the view is affine.
///
/// Q(p) = 1 − |P(p − p0)|², kernel Q² where Q > 0 (Neumann 1992, section 2.3, with P as in the errata:
/// the inverse of the 2×2 block that takes lattice (u, v) to pixels, divided by the radius).
///
/// Minification: with V = (PᵀP)⁻¹, the ellipse's squared semi-axes are V's eigenvalues. Those below
/// narrowest_half_width² are raised to it, so the shape changes continuously with the view, and only where
/// the pixel is coarser than the kernel.
struct Footprint {
  glm::dmat2 p{1.0};  ///< pixel offset to (i, j) / radius; the symmetric root V^(−½) when widened
  double d = -1, e = 0, f = -1;  ///< Q = Ax + By + C + Dx² + Exy + Fy²
  glm::dvec2 half{1.0};          ///< half extents in pixels of the ellipse Q = 0
  /// 1 / (mean of the lattice's sum of Q²) = 3 · (pixels a lattice cell covers) · |det P| / π, because ∫ Q² =
  /// π / (3 |det P|) and there is one kernel a cell; 3 / (π radius²) unless the kernel is widened.
  double weight = 1;
};

/// `radius`: in voxels. Throws InputError for a radius that is not in [0.5, 8], a view that is not finite,
/// and kernels wider than 2^28 pixels.
Footprint make_footprint(const ViewTransform& view, Axis axis, double radius);

/// A, B and C of a kernel whose centre lies at (x0, y0) from the origin, a pixel centre.
struct Coefficients {
  double a, b, c;
};
/// C = 1 − ½(A x0 + B y0) is the erratum to Neumann 1992, section 2.2.
inline Coefficients coefficients(const Footprint& footprint, double x0, double y0) {
  const double a = -2 * footprint.d * x0 - footprint.e * y0;
  const double b = -footprint.e * x0 - 2 * footprint.f * y0;
  return {a, b, 1 - 0.5 * (a * x0 + b * y0)};
}

/// The pass structure (Neumann 1992, Fig. 3): the smallest stride at which the kernels of voxels x ≡ xs, y ≡
/// ys (mod stride) are disjoint on the lattice; ceil(2 radius), since the ellipse is a circle there.
int pass_stride(double radius);

}  // namespace ringsplat

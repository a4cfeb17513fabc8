#pragma once
#include <span>
#include <vector>

#include "truth/scene.hpp"

namespace ringsplat::truth {

/// The emission-absorption integral (Max 1995) of the trilinearly interpolated volume, classified after
/// interpolation.
///
/// Extinction per unit length (the smallest spacing) is −ln(1 − α). The volume ends at its voxels' faces,
/// half a voxel beyond the outer centres, with the nearest voxels' values there. So n slices are n voxels
/// thick, and a volume of one slice is visible. A shaded point's normal is the trilinearly interpolated
/// central difference of the voxels around it (one-sided at the border), normalised. Space is transparent
/// where one of the voxels to interpolate is not a number. Opacity 1 over any length ends the ray with the
/// colour at its front.
///
/// Where Scene::nearest is set the volume is of boxes, each with its voxel's value; shading is as above.
///
/// A ray is cut where it crosses from cell to cell, where the value crosses a point of the transfer function,
/// and where the surface turns away from the light or the viewer: between those the integrand is smooth.
/// Pieces are halved until the Lobatto rule of order eight changes by less than its share of `tolerance`, the
/// error allowed in the final colour. All cores.
///
/// In the other modes nothing is integrated by rule: values are cubic along a ray inside a cell, so their
/// extrema, integral, and first crossing of a value follow in closed form. What lies beside not-a-number
/// counts as no value, which adds nothing; an extremum is never below the function's first point, or above
/// its last one for the least.
std::vector<Rgba> field_truth(const Scene& scene, std::span<const Pixel> pixels, double tolerance = 1e-6);

/// The pixels whose rays cross the volume's box. At all others this truth, and the formula's, is transparent.
ScreenBounds field_bounds(const Scene& scene);

}  // namespace ringsplat::truth

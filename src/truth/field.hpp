#pragma once
#include <span>
#include <vector>

#include "truth/scene.hpp"
#include "volume/synth.hpp"

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
/// Where values are the nearest voxel's, the volume is of boxes, each with its voxel's value; shading is as
/// above.
///
/// A ray is cut where it crosses from cell to cell, where the value crosses a point of the transfer function,
/// and where the surface turns away from the light or the viewer: between those the integrand is smooth.
/// Pieces are halved until the Lobatto rule of order eight changes by less than its share of `tolerance`, the
/// error allowed in the final colour. A depth is found by halving the piece that it is in. All cores.
///
/// In the other modes nothing is integrated by rule: values are cubic along a ray inside a cell, so their
/// extrema, integral, and first crossing of a value follow in closed form. What lies beside not-a-number
/// counts as no value, which adds nothing; an extremum is never below the function's first point, or above
/// its last one for the least, and rays that meet no value at all have none. Of what is left of a value
/// behind others the integral is closed, and the largest is found between places where the value turns or
/// leaves the colours' window.
std::vector<Rgba> field_truth(const Scene& scene, std::span<const Pixel> pixels, double tolerance = 1e-6);

/// The emission-absorption integral of the formula `field` itself over the unit cube, which is the box of the
/// scene's grid (voxel faces, not centres), or over the part of it in the clip box. Field values are
/// multiplied by `scale` to give the volume's (255 for a uint8 volume of synth_source). Does not read
/// scene.values. Shading takes the gradient by central differences of 1e-5 of the cube. A feature thinner
/// than 1/512 of the ray may be missed; else as in field_truth.
std::vector<Rgba> analytic_truth(const Scene& scene, Field field, double scale, std::span<const Pixel> pixels,
                                 double tolerance = 1e-6);

/// The factor by which synth_source multiplies a field in [0, 1] for this scalar type.
double synth_scale(ScalarType type);

/// The pixels whose rays cross the volume's box. At all others this truth, and the formula's, is transparent.
ScreenBounds field_bounds(const Scene& scene);

}  // namespace ringsplat::truth

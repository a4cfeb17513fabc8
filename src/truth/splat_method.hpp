#pragma once
#include <span>
#include <vector>

#include "truth/scene.hpp"

namespace ringsplat::truth {

/// Where the surface normals of the splats' truth come from.
enum class Normals {
  exact,     ///< central differences, normalised
  quantised  ///< the same, rounded to the renderer's 16-bit codes: leaves only numerical error
};

/// The splatting model itself, without the renderer's arithmetic.
///
/// Each voxel is classified, shaded, and corrected to 1 − (1 − α)^d for d unit lengths between slices along
/// the ray. Its kernel is Q², Q = 1 − r², r in kernel radii (Neumann 1992, section 2.2; at least a pixel from
/// the centre), multiplied as Scene::normalisation says: by 3/(π T²) or its widened equivalent, so that
/// weights average to one; by nothing; or by one over the sum of all kernels of an endless slice at the
/// pixel. Each slice of the set most parallel to the view plane is summed at the pixel's centre, clamped
/// (opacity a to [0, 1], colour to [0, a]) and composited front to back.
///
/// Cost: slices × voxels under one kernel a pixel, plus one classification a voxel; all cores.
std::vector<Rgba> splat_method_truth(const Scene& scene, std::span<const Pixel> pixels,
                                     Normals normals = Normals::exact);

/// The pixels that a voxel's kernel may reach. At all others this truth is transparent.
ScreenBounds splat_method_bounds(const Scene& scene);

}  // namespace ringsplat::truth

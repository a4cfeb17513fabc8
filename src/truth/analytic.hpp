#pragma once
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "truth/scene.hpp"
#include "volume/synth.hpp"

namespace ringsplat::truth {

/// The emission-absorption integral of the formula `field` itself over the unit cube, which is the box of the
/// scene's grid (voxel faces, not centres), or over the part of it in the clip box. Field values are
/// multiplied by `scale` to give the volume's (255 for a uint8 volume of synth_source). Does not read
/// scene.values. Shading takes the gradient by central differences of 1e-5 of the cube. A feature thinner
/// than 1/512 of the ray may be missed; else as in field_truth.
std::vector<Rgba> analytic_truth(const Scene& scene, Field field, double scale, std::span<const Pixel> pixels,
                                 double tolerance = 1e-6);

/// The factor by which synth_source multiplies a field in [0, 1] for this scalar type.
double synth_scale(ScalarType type);

}  // namespace ringsplat::truth

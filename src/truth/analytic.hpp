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

/// A pixel's ray in the unit cube: origin + s · step, s in unit lengths (the smallest spacing).
struct CubeRay {
  glm::dvec3 origin, step;
};
CubeRay cube_ray(const Scene& scene, Pixel pixel);

/// Closed forms: unit lengths of the ray inside a shape, or the integral of a field along it.
double length_in_box(const CubeRay& ray, const glm::dvec3& low, const glm::dvec3& high);
double length_in_ball(const CubeRay& ray, const glm::dvec3& centre, double radius);
/// The integral of exp(−|p − centre|² / (2 sigma²)) over the part of the ray in the unit cube.
double integral_of_gaussian(const CubeRay& ray, const glm::dvec3& centre, double sigma);

}  // namespace ringsplat::truth

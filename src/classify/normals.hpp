#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// Quantised surface normal: 0 for "none" (zero or undefined gradient: unlit), else one of the 65018
/// directions of an octahedral lattice (Meyer et al. 2010; Cigolle et al. 2014), coded 1..65018. The largest
/// angular error is 0.57 degrees. Turning a direction by one of the cube's rotations, or mirroring it, turns
/// or mirrors the decoded one alike; to the last bit when only signs change.
using NormalCode = std::uint16_t;
inline constexpr NormalCode no_normal = 0;
inline constexpr std::size_t normal_codes = 65536;
/// The sum of the codes of two opposite directions.
inline constexpr int opposite_codes = 65019;

/// The code of a direction of any length; no_normal when it is zero or not finite.
NormalCode encode_normal(const glm::dvec3& direction);
/// A unit vector; zero for no_normal and for numbers that are no code.
glm::dvec3 decode_normal(NormalCode code);

/// Normals of one z slice, by central differences in world units. They point against the gradient: to lower
/// values, out of dense matter. Differences are one-sided at the volume's border and beside a value that is
/// not finite; a voxel that is not finite has no normal. `below` / `above` are the neighbouring z slices or
/// null at the border; slices hold grid.slice_voxels(Axis::z) scalars of grid.type, native byte order,
/// aligned for the type. `out` has as many codes. Any number of threads may work on different slices.
void slice_normals(const Grid& grid, const std::byte* below, const std::byte* here, const std::byte* above,
                   std::span<NormalCode> out);

}  // namespace ringsplat

#pragma once
#include <memory>
#include <span>
#include <string>

#include "ringsplat/volume/source.hpp"

namespace ringsplat {

/// A value for a point of the unit cube [0, 1]^3 (voxel centres of an n-voxel axis lie at (i + 0.5) / n).
/// Values lie in [0, 1].
using Field = double (*)(double x, double y, double z);

/// An analytic test volume.
struct SynthName {
  const char* name;
  const char* description;  ///< a line
  Field field;              ///< null: "point", which is one voxel of a lattice and not a field
};
std::span<const SynthName> synth_names();

/// The field of that name. Throws InputError listing the names.
Field synth_field(const std::string& name);

/// The field sampled on `grid`: integer types are scaled to the type's positive range (uint8: 0..255,
/// int16: 0..32767), floats stay in [0, 1]. Concurrent. "point" is the one voxel dims / 2. Throws
/// InputError for an unknown name or a grid that fails check().
std::unique_ptr<VolumeSource> synth_source(const std::string& name, const Grid& grid);

}  // namespace ringsplat

#pragma once
#include <memory>
#include <string>
#include <vector>

#include "ringsplat/volume/source.hpp"

namespace ringsplat {

/// Names of the analytic test volumes, with a line of description each.
struct SynthName {
  std::string name, description;
};
const std::vector<SynthName>& synth_names();

/// The field's value at a point of the unit cube [0, 1]^3 (voxel centres of an n-voxel axis lie at (i + 0.5)
/// / n). Names are those of synth_names(), except "point", which is one voxel of a lattice and not a field.
/// Values lie in [0, 1]. Throws InputError listing the names.
using Field = double (*)(double x, double y, double z);
Field synth_field(const std::string& name);

/// The field sampled on `grid`: integer types are scaled to the type's positive range (uint8: 0..255,
/// int16: 0..32767), floats stay in [0, 1]. Concurrent. "point" is the one voxel dims / 2. Throws
/// InputError for an unknown name or a grid that fails check().
std::unique_ptr<VolumeSource> synth_source(const std::string& name, const Grid& grid);

}  // namespace ringsplat

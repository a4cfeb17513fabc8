#pragma once
#include <vector>

#include "options/transfer_function_option.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"
#include "volume/volume_sketch.hpp"

/// What a forecast reads of a volume.
namespace ringsplat::app {

/// The transfer function that a choice makes for the volume: of one of more than 2²⁴ voxels from three
/// sections of z slices, which bounds memory. Throws InputError when the volume is unreadable or has no
/// finite value.
TransferFunction function_for(VolumeSource& source, const TransferFunctionChoice& choice);

VolumeSketch sketch_of(VolumeSource& source);

/// The views of a run to foresee: the first, or three evenly spread ones of a long run.
std::vector<Camera> some_views(const std::vector<Camera>& cameras);

}  // namespace ringsplat::app

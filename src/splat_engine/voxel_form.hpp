#pragma once
#include <memory>

#include "ringsplat/frame/frame_spec.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat {

/// Makes a Made<Voxel> for the voxel type of runs of this precision.
template <class Base, template <class Voxel> class Made, class... Arguments>
std::unique_ptr<Base> make_for_voxels(Precision precision, const Arguments&... arguments) {
  switch (precision) {
    case Precision::half:
      return std::make_unique<Made<HalfVoxel>>(arguments...);
    case Precision::u8:
      return std::make_unique<Made<ByteVoxel>>(arguments...);
    case Precision::float32:
      break;
  }
  return std::make_unique<Made<FloatVoxel>>(arguments...);
}

}  // namespace ringsplat

#pragma once
#include <cstdint>
#include <memory>

#include "frame/frame_geometry.hpp"
#include "protocol/engine.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "splat/voxel_run.hpp"
#include "volume/slice_dealing.hpp"

namespace ringsplat {

/// A frame as the nodes of a rank share it: what was announced, and what follows from it.
struct SplatFrame {
  std::int64_t number = 0;
  Shown shown;
  Splats splats;
  FrameGeometry geometry;
  Footprint footprint;
  FramePlan plan;
};

class RegionDealer;

/// `spec` must be of this method; without a `dealer` regions are dealt in turn. Throws InputError when its
/// view cannot be drawn.
std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, const Grid& grid, SliceDealing dealing,
                                             int renderers, RegionDealer* dealer = nullptr);
/// The same of a geometry that was made of `spec`.
std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, FrameGeometry geometry,
                                             SliceDealing dealing, int renderers,
                                             RegionDealer* dealer = nullptr);

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

#pragma once
#include "frame/engine_setup.hpp"
#include "frame/frame_geometry.hpp"
#include "protocol/engine.hpp"
#include "volume/slice_dealing.hpp"

namespace ringsplat {

/// What the protocol knows of a frame: slices are dealt in turn, and a tile is a region of the image plane.
FramePlan plan_of(const FrameGeometry& geometry, SliceDealing dealing, int renderers);

/// A rank's frames' regions, dealt by the work that the volume's sketch lets foresee
/// (frame/work_dealing.hpp).
class RegionDealer {
 public:
  explicit RegionDealer(const EngineSetup& setup) : setup_(setup) {}
  /// From now on for these ranks and costs; the sketch is the same.
  void use(const EngineSetup& setup) { setup_ = setup; }
  /// Of a frame's geometry, before its plan is made.
  void deal(const FrameSpec& spec, FrameGeometry& geometry);

 private:
  EngineSetup setup_;
  ShownPoints shown_;
};

}  // namespace ringsplat

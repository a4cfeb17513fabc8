#pragma once
#include <cstdint>
#include <functional>

#include "ringsplat/base/image.hpp"
#include "ringsplat/volume/grid.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// Takes a frame's picture once its canvas is finished.
using TakePicture = std::function<void(std::int64_t frame, Image&& picture)>;

/// What a rank's engine is made for, whatever its method.
struct EngineSetup {
  Grid grid;
  int gps = 1, renderers = 1;
  const SliceStore& slices;  ///< of this rank's GP, none when it hosts no GP; must outlive the engine
  int threads = 1;           ///< that share a node's work
  bool skip_empty = true;    ///< slices that the transfer function makes transparent have no part in a frame
  bool timed = false;        ///< seconds by stage are measured
  TakePicture take;          ///< called on the frame buffer's rank
};

}  // namespace ringsplat

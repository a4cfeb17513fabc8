#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "frame/work_estimate.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/volume/grid.hpp"
#include "volume/slice_store.hpp"
#include "volume/volume_sketch.hpp"

namespace ringsplat {

/// Takes a frame's picture once its canvas is finished.
using TakePicture = std::function<void(std::int64_t frame, Image&& picture)>;

/// What an engine of any method is made from.
struct EngineSetup {
  Grid grid;
  int gps = 1, renderers = 1;
  int bundle = 1;          ///< consecutive slices that a GP gets together
  bool colocated = false;  ///< Renderer r is on GP r's rank
  /// What dealing foresees the work from; null: regions are dealt in turn. The same on every rank.
  std::shared_ptr<const VolumeSketch> sketch = {};
  WorkCosts splat_costs = usual_splat_costs, sheet_costs = usual_sheet_costs;
  /// This rank's GP's slices, shared by its engines; an empty store without a GP.
  std::shared_ptr<const SliceStore> slices;
  /// Sketch and slices of further volumes on the same grid, which frames may show by their numbers, from 1.
  struct Other {
    std::shared_ptr<const VolumeSketch> sketch;
    std::shared_ptr<const SliceStore> slices;
  };
  std::vector<Other> others = {};
  int threads = 1;               ///< threads that share a node's work
  std::uint64_t kept_bytes = 0;  ///< of sheets' planes that each Renderer keeps from frame to frame
  bool skip_empty = true;        ///< leave out slices that the transfer function makes transparent
  TakePicture take = {};         ///< called on the frame buffer's rank

  SliceDealing dealing() const { return {gps, bundle}; }
};

}  // namespace ringsplat

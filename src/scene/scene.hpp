#pragma once
#include <map>
#include <vector>

#include "scene/load.hpp"

namespace ringsplat {

/// A volume dealt to the GPs, ready to be rendered: this process's slices and what all processes know.
struct Scene {
  Grid grid;
  std::map<int, SliceStore> stores;  ///< by GP, those of this process
  ValueStatistics values;
  std::shared_ptr<const VolumeSketch> sketch;  ///< of the whole volume
};

/// Deals all requested levels of an opened volume to GPs and gathers its values' statistics.
/// `gps_of_process` as for deal_slices(). All processes call it, with the same grid and options.
Scene deal_scene(OpenedVolume& volume, const LoadOptions& options, SliceDealing dealing,
                 const std::vector<std::vector<int>>& gps_of_process, Collectives& collectives);

/// The scene of a volume whose z slices are dealt already; their values are shared, not copied. The other
/// axes' slices, normals and levels come by exchange. `values` are left to the caller.
Scene deal_scene_again(const Grid& grid, const std::map<int, SliceStore>& stores, const LoadOptions& options,
                       SliceDealing dealing, const std::vector<std::vector<int>>& gps_of_process,
                       Collectives& collectives);

}  // namespace ringsplat

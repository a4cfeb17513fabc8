#include "scene/scene.hpp"

#include <algorithm>
#include <utility>

#include "ringsplat/volume/reduced.hpp"

namespace ringsplat {
namespace {

void share_ranges(std::map<int, SliceStore>& stores, const LoadOptions& options, int gps,
                  const std::vector<std::vector<int>>& gps_of_process, Collectives& collectives) {
  share_slice_ranges(stores, collectives);
  if (options.with_cell_ranges) share_cell_ranges(stores, gps, gps_of_process, collectives);
}

void add_level(Scene& scene, const Reduction& reduction, OpenedVolume& volume, const LoadOptions& options,
               int gps, const std::vector<std::vector<int>>& gps_of_process, Collectives& collectives) {
  OpenedVolume reduced{reduced_grid(volume.grid, reduction), volume.concurrent, nullptr};
  if (volume.source) reduced.source = reduced_source(*volume.source, reduction);
  reduced.slab_depth = reduced_slab_depth(volume.slab_depth, reduction);
  LoadOptions of_level = options;
  if (options.clip) of_level.clip = reduced_box(*options.clip, volume.grid, reduction);
  auto stores = deal_slices(reduced, of_level, gps, gps_of_process, collectives);
  share_ranges(stores, options, gps, gps_of_process, collectives);
  for (auto& [gp, store] : stores) scene.stores.at(gp).add_level(reduction.factor, std::move(store));
}

/// `all` for a part of the loading: the share of its time that begins at `begin`.
LoadOptions told_of(LoadOptions options, const LoadOptions& all, double begin, double share) {
  if (all.told) options.told = [&all, begin, share](double part) { all.told(begin + share * part); };
  return options;
}

/// The volume's share of the time, and with a factor a level's: few voxels are left of it, but it reads as
/// many.
double share_of(const LoadOptions& options, int factor = 1) {
  double sum = 1;
  for (const int level : options.factors) sum += level > 1 ? 1.0 / level : 0;
  return 1.0 / factor / sum;
}

}  // namespace

Scene deal_scene(OpenedVolume& volume, const LoadOptions& options, int gps,
                 const std::vector<std::vector<int>>& gps_of_process, Collectives& collectives) {
  if (options.clip) check(*options.clip, volume.grid);
  Scene scene;
  scene.grid = volume.grid;
  const bool whole = std::find(options.factors.begin(), options.factors.end(), 1) != options.factors.end();
  // Statistics are the full volume's at every level, so that presets do not change with the level.
  const LoadOptions values_only{{false, false, true}, false};
  double begun = share_of(options);
  scene.stores = deal_slices(volume, told_of(whole ? options : values_only, options, 0, begun), gps,
                             gps_of_process, collectives);
  scene.values = share_values(scene.stores, volume.grid, volume.notes, collectives);
  if (whole)
    share_ranges(scene.stores, options, gps, gps_of_process, collectives);
  else
    for (auto& [gp, store] : scene.stores) store = SliceStore(volume.grid, gp, gps, {}, false);
  for (const int factor : options.factors)
    if (factor > 1) {
      const double share = share_of(options, factor);
      add_level(scene, {factor, options.prefilter}, volume, told_of(options, options, begun, share), gps,
                gps_of_process, collectives);
      begun += share;
    }
  return scene;
}

}  // namespace ringsplat

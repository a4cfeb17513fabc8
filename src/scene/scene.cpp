#include "scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "ringsplat/volume/reduced.hpp"
#include "scene/dealer.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat {
namespace {

void share_ranges(std::map<int, SliceStore>& stores, const LoadOptions& options, const Sharing& sharing) {
  share_slice_ranges(stores, sharing.collectives);
  if (options.with_cell_ranges) share_cell_ranges(stores, sharing);
}

void add_level(Scene& scene, const Reduction& reduction, OpenedVolume& volume, const LoadOptions& options,
               const Sharing& sharing) {
  OpenedVolume reduced{reduced_grid(volume.grid, reduction), volume.concurrent, nullptr};
  if (volume.source) reduced.source = reduced_source(*volume.source, reduction);
  reduced.layer_depth = reduced_layer_depth(volume.layer_depth, reduction);
  LoadOptions of_level = options;
  if (options.clip) of_level.clip = reduced_box(*options.clip, volume.grid, reduction);
  auto stores = deal_slices(reduced, of_level, sharing);
  share_ranges(stores, options, sharing);
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

/// Deals the labels of all levels as the volume is dealt, and gives them to its stores.
void add_labels(Scene& scene, OpenedVolume& volume, LoadOptions options, const Sharing& sharing) {
  OpenedVolume labels{volume.grid, volume.concurrent};
  labels.grid.type = ScalarType::uint8;
  if (volume.source) labels.source = std::make_unique<ForwardingSource>(*volume.source->labels());
  options.with_normals = options.with_cell_ranges = options.prefilter = false;
  options.told = {};
  Scene dealt = deal_scene(labels, options, sharing);
  scene.labels = std::move(dealt.values.labels);
  std::erase(scene.labels, 0.0);
  for (auto& [gp, store] : scene.stores)
    store.know_labels(std::make_shared<const SliceStore>(std::move(dealt.stores.at(gp))));
}

}  // namespace

Scene deal_scene(OpenedVolume& volume, const LoadOptions& options, const Sharing& sharing) {
  if (options.clip) check(*options.clip, volume.grid);
  Scene scene;
  scene.grid = volume.grid;
  const bool whole = std::ranges::count(options.factors, 1) > 0;
  // Statistics are the full volume's at every level, so that presets do not change with the level.
  const LoadOptions values_only{{false, false, true}, false};
  double begun = share_of(options);
  scene.stores = deal_slices(volume, told_of(whole ? options : values_only, options, 0, begun), sharing);
  const auto& kept = whole ? options.kept_axes : values_only.kept_axes;
  const auto axis = std::find(kept.begin(), kept.end(), true) - kept.begin();
  if (axis < 3)
    scene.sketch = share_sketch(scene.stores, volume.grid, all_axes[std::size_t(axis)], sharing.collectives);
  // Who is told may end the loading; the values and ranges of a large volume take their time, too.
  const auto tell = [&] {
    if (options.told) options.told(begun);
  };
  tell();
  scene.values = share_values(scene.stores, volume.grid, volume.notes, sharing.collectives);
  tell();
  if (whole)
    share_ranges(scene.stores, options, sharing);
  else
    for (auto& [gp, store] : scene.stores) store = SliceStore(volume.grid, gp, sharing.dealing, {}, false);
  for (const int factor : options.factors)
    if (factor > 1) {
      const double share = share_of(options, factor);
      add_level(scene, {factor, options.prefilter}, volume, told_of(options, options, begun, share), sharing);
      begun += share;
    }
  if (volume.has_labels) add_labels(scene, volume, options, sharing);
  return scene;
}

Scene deal_scene_again(const Grid& grid, const std::map<int, SliceStore>& stores, const LoadOptions& options,
                       const Sharing& sharing) {
  if (options.clip) check(*options.clip, grid);
  Scene scene;
  scene.grid = grid;
  scene.sketch = share_sketch(stores, grid, Axis::z, sharing.collectives);
  const auto deal = [&](const Reduction& reduction) {
    LoadOptions of_level = options;
    if (options.clip) of_level.clip = reduced_box(*options.clip, grid, reduction);
    const auto supply = stored_supply(grid, stores, reduction, sharing);
    const auto* known = reduction.factor == 1 ? &stores : nullptr;
    auto dealt = deal_slices(reduced_grid(grid, reduction), *supply, {of_level, sharing, known});
    share_ranges(dealt, options, sharing);
    return dealt;
  };
  const bool whole = std::ranges::count(options.factors, 1) > 0;
  const bool more_than_z = options.with_normals || options.kept_axes[0] || options.kept_axes[1];
  if (whole && more_than_z) {
    scene.stores = deal({});
  } else {
    const std::array<bool, 3> kept{false, false, whole && options.kept_axes[2]};
    for (const auto& [gp, store] : stores)
      scene.stores.emplace(gp, SliceStore(grid, gp, sharing.dealing, kept, false, &store));
    if (whole) share_ranges(scene.stores, options, sharing);
  }
  for (const int factor : options.factors)
    if (factor > 1)
      for (auto& [gp, level] : deal({factor, options.prefilter}))
        scene.stores.at(gp).add_level(factor, std::move(level));
  return scene;
}

OpenedVolume open_everywhere(Collectives& collectives,
                             const std::function<std::unique_ptr<VolumeSource>()>& open,
                             const std::string& name) {
  OpenedVolume volume;
  volume.name = name;
  const auto open_it = [&] {
    volume.source = open();
    check(volume.source->grid(), "the volume");
    volume.notes = volume.source->notes();
    volume.facts = facts_of(volume.source->grid());
    const Facts more = volume.source->facts();
    volume.facts.insert(volume.facts.end(), more.begin(), more.end());
  };
  const bool is_first = collectives.process() == 0;
  agree(collectives, is_first ? input_error_of(open_it) : std::string());
  Block known;
  if (volume.source)
    known = to_bytes(volume.source->grid(), volume.source->concurrent(), volume.source->layer_depth(),
                     volume.notes.fill, volume.source->labels() != nullptr);
  read_block(collectives.broadcast(std::move(known), 0), "a volume's grid", volume.grid, volume.concurrent,
             volume.layer_depth, volume.notes.fill, volume.has_labels);
  if (!volume.concurrent) return volume;
  agree(collectives, is_first ? std::string() : input_error_of(open_it));
  require_same(collectives, volume.facts, fmt::format("sees another volume at {}", name),
               "give every machine the same files, or a path that leads to one place from all of them");
  return volume;
}

}  // namespace ringsplat

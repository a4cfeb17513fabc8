#include "scene/scene.hpp"

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
  if (all.told)
    options.told = [&all, begin, share](double part, bool in_step) {
      all.told(begin + share * part, in_step);
    };
  return options;
}

/// The volume's share of the time, and with a factor a level's: few voxels are left of it, but it reads as
/// many.
double share_of(const LoadOptions& options, int factor = 1) {
  double sum = 1;
  for (const int level : options.factors) sum += level > 1 ? 1.0 / level : 0;
  return 1.0 / factor / sum;
}

/// The labels of a reduced volume's voxels: of the voxels in its place the first one's that has any, so that
/// thin lines stay.
class CoarseLabels final : public ForwardingSource {
 public:
  CoarseLabels(VolumeSource& labels, const Grid& grid, int factor)
      : ForwardingSource(labels, grid), factor_(factor) {}
  int layer_depth() const override { return reduced_layer_depth(source_.layer_depth(), {factor_}); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    const glm::ivec3 dims = grid().dims, fine = source_.grid().dims;
    std::ranges::fill(out, std::byte{0});
    std::vector<std::byte> slice(source_.grid().slice_bytes(Axis::z));
    for (int z = first * factor_; z < std::min((first + count) * factor_, fine.z); ++z) {
      source_.read_slices(z, 1, slice);
      std::byte* to = out.data() + std::size_t(z / factor_ - first) * grid().slice_bytes(Axis::z);
      for (int y = 0; y < std::min(fine.y, dims.y * factor_); ++y)
        for (int x = 0; x < std::min(fine.x, dims.x * factor_); ++x)
          if (std::byte& label = to[y / factor_ * dims.x + x / factor_]; label == std::byte{0})
            label = slice[std::size_t(y) * std::size_t(fine.x) + std::size_t(x)];
    }
  }

 private:
  int factor_;
};

/// Deals the labels of all levels as the volume is dealt, and gives them to its stores.
void add_labels(Scene& scene, OpenedVolume& volume, LoadOptions options, const Sharing& sharing) {
  OpenedVolume labels{volume.grid, volume.concurrent, nullptr};
  labels.grid.type = ScalarType::uint8;
  if (volume.source) labels.source = std::make_unique<ForwardingSource>(*volume.source->labels());
  options.with_normals = options.with_cell_ranges = false;
  options.told = {};
  const std::vector<int> factors = std::move(options.factors);
  options.factors.assign(std::size_t(std::ranges::count(factors, 1)), 1);
  Scene dealt = deal_scene(labels, options, sharing);
  for (const int factor : factors) {
    if (factor == 1) continue;
    OpenedVolume level{reduced_grid(labels.grid, {factor, options.prefilter}), labels.concurrent, nullptr};
    if (labels.source) level.source = std::make_unique<CoarseLabels>(*labels.source, level.grid, factor);
    for (auto& [gp, store] : deal_slices(level, options, sharing))
      dealt.stores.at(gp).add_level(factor, std::move(store));
  }
  scene.labels = std::move(dealt.values.labels);
  std::erase(scene.labels, 0.0);
  for (auto& [gp, store] : scene.stores)
    store.know_labels(std::make_shared<const SliceStore>(std::move(dealt.stores.at(gp))));
}

/// The scene of LoadOptions::half_of.
Scene deal_half(OpenedVolume& half, LoadOptions options, const Sharing& sharing) {
  const Grid grid = *std::exchange(options.half_of, std::nullopt);
  std::erase(options.factors, 1);
  for (int& factor : options.factors) factor /= 2;
  Scene scene = deal_scene(half, options, sharing);
  scene.grid = grid;
  for (auto& [gp, store] : scene.stores) {
    SliceStore levels(grid, gp, sharing.dealing, {}, false);
    for (const int factor : options.factors) levels.add_level(2 * factor, store.level(factor));
    store = std::move(levels);
  }
  auto sketch = std::make_shared<VolumeSketch>(*scene.sketch);
  sketch->dims = grid.dims;
  scene.sketch = std::move(sketch);
  return scene;
}

/// What process 0 tells the others of the volume it has opened. In one piece, as a grid by itself is told by
/// its members elsewhere (formats/decode/messages.hpp), and there may be one way for each type.
struct Known {
  Grid grid;
  bool concurrent = false;
  int layer_depth = 1;
  std::optional<double> fill;  ///< what the values' statistics leave out
  bool has_labels = false;
};

}  // namespace

Scene deal_scene(OpenedVolume& volume, const LoadOptions& options, const Sharing& sharing) {
  if (options.half_of) return deal_half(volume, options, sharing);
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
    if (options.told) options.told(begun, true);
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
  Block block;
  if (volume.source)
    block = to_bytes(Known{volume.source->grid(), volume.source->concurrent(), volume.source->layer_depth(),
                           volume.notes.fill, volume.source->labels() != nullptr});
  block = collectives.broadcast(std::move(block), 0);
  const auto known = value_of<Known>(block, "a volume's grid");
  volume.grid = known.grid;
  volume.concurrent = known.concurrent;
  volume.layer_depth = known.layer_depth;
  volume.notes.fill = known.fill;
  volume.has_labels = known.has_labels;
  if (!volume.concurrent) return volume;
  agree(collectives, is_first ? std::string() : input_error_of(open_it));
  require_same(collectives, volume.facts, fmt::format("sees another volume at {}", name),
               "give every machine the same files, or a path that leads to one place from all of them");
  return volume;
}

}  // namespace ringsplat

#include "scene/load.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "classify/normals.hpp"
#include "net/blocks.hpp"
#include "net/same_facts.hpp"
#include "ringsplat/base/error.hpp"
#include "scene/decoded_slices.hpp"
#include "scene/load_pace.hpp"
#include "volume/clipped.hpp"
#include "volume/slice_ranges.hpp"

namespace ringsplat {
namespace {

/// Bytes of z slices sent in one round, over all processes.
constexpr std::size_t batch_bytes = std::size_t{8} << 20;

template <class T>
void put(Block& out, const T& value) {
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), first, first + sizeof(T));
}

template <class T>
T get(std::span<const std::byte> in, std::size_t& at) {
  T value;
  if (!take(in, at, value))
    throw RunError("a volume exchange message is too short", "all ranks must run the same build");
  return value;
}

std::span<const std::byte> get_bytes(std::span<const std::byte> in, std::size_t& at, std::size_t count) {
  if (in.size() - at < count)
    throw RunError("a volume exchange message is too short", "all ranks must run the same build");
  const auto part = in.subspan(at, count);
  at += count;
  return part;
}

/// State of one deal, shared by its rounds.
class Dealer {
 public:
  Dealer(OpenedVolume& volume, const LoadOptions& options, int gps,
         const std::vector<std::vector<int>>& gps_of_process, Collectives& collectives)
      : volume_(volume),
        grid_(volume.grid),
        options_(options),
        gps_(gps),
        gps_of_process_(gps_of_process),
        collectives_(collectives),
        process_of_gp_(std::size_t(gps)),
        slice_bytes_(grid_.slice_bytes(Axis::z)),
        lit_(options.clip.value_or(whole_box(grid_))),
        batch_(std::max<int>(1, static_cast<int>(batch_bytes / std::max<std::size_t>(1, slice_bytes_)))),
        pace_(grid_.dims.z, options.told) {
    if (!volume.concurrent || volume.slab_depth > 1)
      decoded_.emplace(volume.source.get(), grid_, volume.slab_depth, collectives.process(),
                       volume.concurrent ? collectives.processes() : 1, batch_);
    for (std::size_t p = 0; p < gps_of_process.size(); ++p)
      for (const int gp : gps_of_process[p]) process_of_gp_[std::size_t(gp)] = static_cast<int>(p);
    for (const int gp : gps_of_process[std::size_t(collectives.process())])
      stores_.emplace(gp, SliceStore(grid_, gp, gps, options.kept_axes, options.with_normals))
          .first->second.know_normals_within(lit_);
  }

  std::map<int, SliceStore> deal() {
    pace_.begin();
    for (int z = 0; z < grid_.dims.z;) {
      const int end = next_end(z);
      if (decoded_) hand_out(z, end);
      exchange(z, end);
      pace_.dealt(end);
      z = end;
    }
    return std::move(stores_);
  }

 private:
  int owning_process(int z) const { return process_of_gp_[std::size_t(SliceStore::owner_of(z, gps_))]; }
  bool mine(int z) const { return owning_process(z) == collectives_.process(); }

  /// The end of the batch of slices that begins at z. Slices and their neighbours are decoded before it.
  int next_end(int z) {
    const int end = std::min(grid_.dims.z, z + batch_);
    if (!decoded_) return end;
    const auto known = [&] { return decoded_->end() == grid_.dims.z ? grid_.dims.z : decoded_->end() - 1; };
    while (known() <= z) {
      std::string error;
      try {
        decoded_->decode_group(z - 1, [&](double read) { pace_.read(read); });
      } catch (const InputError& e) {
        error = e.what();
      }
      agree(collectives_, error);
    }
    return std::min(end, known());
  }

  /// Whoever has decoded slices [z0, z1) and their neighbours gives them to those that need them.
  void hand_out(int z0, int z1) {
    std::vector<Block> out(std::size_t(collectives_.processes()));
    for (int z = std::max(0, z0 - 1); z < std::min(grid_.dims.z, z1 + 1); ++z) {
      const std::byte* slice = decoded_->find(z);
      for (int p = 0; slice != nullptr && p < collectives_.processes(); ++p)
        if (p != collectives_.process() && needed_by(p, z, z0, z1)) {
          Block& block = out[std::size_t(p)];
          put(block, z);
          block.insert(block.end(), slice, slice + slice_bytes_);
        }
    }
    received_.clear();
    for (const auto& in : collectives_.all_to_all(std::move(out)))
      for (std::size_t at = 0; at < in.size();) {
        const int z = get<int>(in, at);
        const auto bytes = get_bytes(in, at, slice_bytes_);
        received_[z].assign(bytes.begin(), bytes.end());
      }
  }

  bool needed_by(int process, int z, int z0, int z1) const {
    const int reach = options_.with_normals ? 1 : 0;
    for (int owner_z = std::max(z0, z - reach); owner_z <= std::min(z1 - 1, z + reach); ++owner_z)
      if (owning_process(owner_z) == process) return true;
    return false;
  }

  const std::byte* slice_at(int z) {
    if (z < 0 || z >= grid_.dims.z) return nullptr;
    if (const std::byte* own = decoded_ ? decoded_->find(z) : nullptr) return own;
    const auto found = received_.find(z);
    if (found != received_.end()) return found->second.data();
    if (decoded_)
      throw RunError(fmt::format("no rank handed out slice {}", z), "all ranks must run the same build");
    Block slice(slice_bytes_);
    volume_.source->read_slices(z, 1, slice);
    return received_.emplace(z, std::move(slice)).first->second.data();
  }

  /// Owners of z slices [z0, z1) keep them and send every GP its lines of the other two axes.
  void exchange(int z0, int z1) {
    std::vector<Block> out(std::size_t(collectives_.processes()));
    std::string error;
    try {
      if (!decoded_) received_.erase(received_.begin(), received_.lower_bound(z0 - 1));
      for (int z = z0; z < z1; ++z)
        if (mine(z)) send_slice(z, out);
    } catch (const InputError& e) {
      error = e.what();
    }
    agree(collectives_, error);
    for (const auto& block : collectives_.all_to_all(std::move(out))) place_lines(block);
  }

  void send_slice(int z, std::vector<Block>& out) {
    const std::byte* here = slice_at(z);
    std::vector<std::uint16_t> normals;
    if (options_.with_normals) {
      normals.assign(grid_.slice_voxels(Axis::z), no_normal);
      if (lit_ == whole_box(grid_))
        slice_normals(grid_, slice_at(z - 1), here, slice_at(z + 1), normals);
      else if (z >= lit_.first.z && z < lit_.end.z)
        make_normals_within(z, normals);
    }
    const std::span<const std::byte> values(here, slice_bytes_);
    if (options_.kept_axes[2]) {
      SliceStore& store = stores_.at(SliceStore::owner_of(z, gps_));
      std::memcpy(store.values(Axis::z, z).data(), here, slice_bytes_);
      std::copy(normals.begin(), normals.end(), store.normals(Axis::z, z).begin());
    }
    for (const Axis axis : {Axis::x, Axis::y}) {
      if (!options_.kept_axes[std::size_t(axis)]) continue;
      for (int gp = 0; gp < gps_; ++gp) {
        Block lines;
        pack_columns(grid_, axis, gp, gps_, values, normals, lines);
        Block& block = out[std::size_t(process_of_gp_[std::size_t(gp)])];
        put(block, z);
        put(block, axis);
        put(block, gp);
        put(block, std::uint64_t(lines.size()));
        block.insert(block.end(), lines.begin(), lines.end());
      }
    }
  }

  /// The normals of a slice of the volume cropped to lit_, at their places in the whole slice.
  void make_normals_within(int z, std::vector<NormalCode>& normals) {
    const Grid part = clipped_grid(grid_, lit_);
    std::array<Block, 3> slices;
    for (int k = 0; k < 3; ++k) {
      const int at = z + k - 1;
      if (at < lit_.first.z || at >= lit_.end.z) continue;
      slices[std::size_t(k)].resize(part.slice_bytes(Axis::z));
      copy_clipped(grid_, lit_, slice_at(at), slices[std::size_t(k)].data());
    }
    const auto values = [&](std::size_t k) { return slices[k].empty() ? nullptr : slices[k].data(); };
    std::vector<NormalCode> within(part.slice_voxels(Axis::z));
    slice_normals(part, values(0), values(1), values(2), within);
    const auto width = std::ptrdiff_t(part.dims.x);
    for (int y = 0; y < part.dims.y; ++y)
      std::copy_n(within.begin() + y * width, width,
                  normals.begin() + std::ptrdiff_t(lit_.first.y + y) * grid_.dims.x + lit_.first.x);
  }

  void place_lines(std::span<const std::byte> block) {
    for (std::size_t at = 0; at < block.size();) {
      const int z = get<int>(block, at);
      const Axis axis = get<Axis>(block, at);
      const int gp = get<int>(block, at);
      const auto size = get<std::uint64_t>(block, at);
      const auto store = stores_.find(gp);
      const bool crosses = axis == Axis::x || axis == Axis::y;
      if (store == stores_.end() || !crosses || !store->second.keeps(axis) ||
          !unpack_columns(store->second, axis, gp, gps_, z, options_.with_normals,
                          get_bytes(block, at, size)))
        throw RunError("a volume exchange message does not fit this rank's slices",
                       "all ranks must run the same build");
    }
  }

  OpenedVolume& volume_;
  const Grid& grid_;
  const LoadOptions& options_;
  int gps_;
  const std::vector<std::vector<int>>& gps_of_process_;
  Collectives& collectives_;
  std::vector<int> process_of_gp_;
  std::size_t slice_bytes_;
  VoxelBox lit_;  ///< where normals are made
  std::map<int, SliceStore> stores_;
  int batch_;                             ///< slices of a round
  std::optional<DecodedSlices> decoded_;  ///< not where every process reads its own slices
  std::map<int, Block> received_;         ///< z slices this process has for the round
  LoadPace pace_;
};

/// Gathers the values of all processes; a process may have none.
template <class T>
std::vector<T> gathered(Collectives& collectives, const std::vector<T>& mine) {
  std::vector<T> all;
  for (const auto& one : collectives.all_gather(block_of(std::as_bytes(std::span(mine)))))
    for (std::size_t at = 0; at < one.size();) all.push_back(get<T>(one, at));
  return all;
}

/// What process 0 tells the others of the volume it has opened.
struct Known {
  Grid grid;
  std::uint8_t concurrent = 0;
  std::int32_t slab_depth = 1;
  std::uint8_t has_fill = 0;
  double fill = 0;  ///< what the values' statistics leave out
};

/// Copies `known` into `volume`; throws RunError when such a volume cannot exist.
void take_known(const Known& known, OpenedVolume& volume) {
  const auto type = int(known.grid.type), last = int(ScalarType::float64);
  try {
    if (type < 0 || type > last || known.concurrent > 1 || known.has_fill > 1)
      throw InputError("its type is none");
    check(known.grid, "its grid");
    if (known.slab_depth < 1) throw InputError("its slabs have no slices");
  } catch (const InputError& e) {
    throw RunError(fmt::format("rank 0 announced a volume that cannot be: {}", e.what()));
  }
  volume.grid = known.grid;
  volume.concurrent = known.concurrent == 1;
  volume.slab_depth = known.slab_depth;
  if (known.has_fill == 1) volume.notes.fill = known.fill;
}

bool is_of(const Grid& grid, const SliceRange& range) {
  const auto is_axis = std::find(all_axes.begin(), all_axes.end(), range.axis) != all_axes.end();
  return is_axis && range.slice >= 0 && range.slice < grid.slices(range.axis);
}

}  // namespace

OpenedVolume open_everywhere(Collectives& collectives,
                             const std::function<std::unique_ptr<VolumeSource>()>& open,
                             const std::string& name) {
  OpenedVolume volume;
  std::string error;
  const auto try_open = [&] {
    try {
      volume.source = open();
      check(volume.source->grid(), "the volume");
      volume.notes = volume.source->notes();
      volume.facts = facts_of(volume.source->grid());
      const Facts more = volume.source->facts();
      volume.facts.insert(volume.facts.end(), more.begin(), more.end());
    } catch (const InputError& e) {
      error = e.what();
    }
  };
  if (collectives.process() == 0) try_open();
  agree(collectives, error);

  Block block;
  if (volume.source) {
    const auto& fill = volume.notes.fill;
    block = block_of_value(Known{volume.source->grid(), volume.source->concurrent(),
                                 volume.source->slab_depth(), fill.has_value(), fill.value_or(0)});
  }
  block = collectives.broadcast(std::move(block), 0);
  take_known(value_of<Known>(block, "a volume's grid"), volume);
  if (!volume.concurrent) return volume;
  if (collectives.process() != 0) try_open();
  agree(collectives, error);
  require_same(collectives, volume.facts, fmt::format("sees another volume at {}", name),
               "give every machine the same files, or a path that leads to one place from all of them");
  // Voxels are read into memory for the grid that was broadcast.
  if (facts_of(volume.source->grid()) != facts_of(volume.grid))
    throw RunError("rank 0 told of another grid than it compared", "all ranks must run the same build");
  return volume;
}

std::map<int, SliceStore> deal_slices(OpenedVolume& volume, const LoadOptions& options, int gps,
                                      const std::vector<std::vector<int>>& gps_of_process,
                                      Collectives& collectives) {
  return Dealer(volume, options, gps, gps_of_process, collectives).deal();
}

void share_slice_ranges(std::map<int, SliceStore>& stores, Collectives& collectives) {
  std::vector<SliceRange> mine;
  for (const auto& [gp, store] : stores)
    for (const Axis axis : all_axes)
      for (int s = 0; store.keeps(axis) && s < store.grid().slices(axis); ++s)
        if (store.owns(s)) mine.push_back(slice_range(store.slice(axis, s)));
  const std::vector<SliceRange> all = gathered(collectives, mine);
  for (const auto& [gp, store] : stores)
    if (!std::all_of(all.begin(), all.end(),
                     [&s = store](const SliceRange& r) { return is_of(s.grid(), r); }))
      throw RunError("a rank sent the range of a slice that the volume does not have",
                     "all ranks must run the same build");
  const auto ranges = std::make_shared<const SliceRanges>(all);
  for (auto& [gp, store] : stores) store.know_ranges(ranges);
}

}  // namespace ringsplat

#include "scene/dealer.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "net/agree.hpp"
#include "net/blocks.hpp"

namespace ringsplat {
namespace {

/// Every process reads the slices that it needs.
class ReadingSupply final : public SliceSupply {
 public:
  explicit ReadingSupply(VolumeSource& source) : source_(source) {}

  int available_from(int) override { return source_.grid().dims.z; }
  void hand_out(int first, int, const Needed&) override {
    read_.erase(read_.begin(), read_.lower_bound(first));
  }
  const std::byte* slice(int z) override {
    if (const auto found = read_.find(z); found != read_.end()) return found->second.data();
    Block slice(source_.grid().slice_bytes(Axis::z));
    source_.read_slices(z, 1, slice);
    return read_.emplace(z, std::move(slice)).first->second.data();
  }

 private:
  VolumeSource& source_;
  std::map<int, Block> read_;
};

/// Whoever holds a slice sends it to those that need it.
class SendingSupply : public SliceSupply {
 public:
  SendingSupply(const Grid& grid, Collectives& collectives)
      : slice_bytes_(grid.slice_bytes(Axis::z)), slices_(grid.dims.z), collectives_(collectives) {}

  void hand_out(int first, int end, const Needed& needed) final {
    std::vector<Block> out(std::size_t(collectives_.processes()));
    for (int z = first; z < end; ++z) {
      const std::byte* slice = held(z);
      for (int p = 0; slice != nullptr && p < collectives_.processes(); ++p) {
        if (p == collectives_.process() || !needed(p, z)) continue;
        Block& block = out[std::size_t(p)];
        append(block, z);
        block.insert(block.end(), slice, slice + slice_bytes_);
      }
    }
    received_.clear();
    for (const Block& in : collectives_.all_to_all(std::move(out)))
      for (std::size_t at = 0; at < in.size();) {
        const int z = next_value<int>(in, at);
        const auto values = next_bytes(in, at, slice_bytes_);
        received_[z].assign(values.begin(), values.end());
      }
  }

  const std::byte* slice(int z) final {
    const std::byte* own = held(z);
    return own != nullptr ? own : received_.at(z).data();
  }

 protected:
  /// Null when this process has not got it.
  virtual const std::byte* held(int z) = 0;

  const std::size_t slice_bytes_;
  const int slices_;
  Collectives& collectives_;

 private:
  std::map<int, Block> received_;  ///< for the batch
};

int slices_of(std::int64_t count) {
  return int(std::min<std::int64_t>(count, std::numeric_limits<int>::max()));
}

/// Decodes group by group. A group has one span of slices for each process that reads: whole layers, as few
/// as make a batch. So every layer is decoded by one process, once. A process holds one span, and of the
/// group before it the slices that are still needed.
class DecodingSupply final : public SendingSupply {
 public:
  /// `told(z)`: how far all readers are by now, if each is as fast as this one.
  DecodingSupply(const OpenedVolume& volume, std::function<void(double z)> told, Collectives& all)
      : SendingSupply(volume.grid, all),
        source_(volume.source.get()),
        depth_(volume.layer_depth),
        told_(std::move(told)) {
    const std::int64_t readers = volume.concurrent ? all.processes() : 1;
    span_ = slices_of(depth_ * std::max<std::int64_t>(1, batch_of(volume.grid) / (depth_ * readers)));
    group_ = slices_of(span_ * readers);
  }

  int available_from(int z) override {
    // The last decoded slice lacks its neighbour.
    const auto end = [&] { return end_ == slices_ ? slices_ : end_ - 1; };
    while (end() <= z) agree_after(collectives_, [&] { decode_group(z - 1); });
    return end();
  }

 private:
  /// Forgets slices before `needed` and decodes this process's span of the next group.
  void decode_group(int needed) {
    decoded_.erase(decoded_.begin(), decoded_.lower_bound(needed));
    const std::int64_t begin = end_, first = begin + std::int64_t(collectives_.process()) * span_;
    end_ = slices_of(std::min<std::int64_t>(slices_, begin + group_));
    const auto last = std::min<std::int64_t>(end_, first + span_);
    if (source_ == nullptr || first >= last) return;
    for (std::int64_t z = first; z < last; z += depth_) {
      const auto count = std::min<std::int64_t>(depth_, last - z);
      Block layer(std::size_t(count) * slice_bytes_);
      source_->read_slices(int(z), int(count), layer);
      const auto* slice = layer.data();
      for (int k = 0; k < count; ++k, slice += slice_bytes_)
        decoded_.emplace(int(z) + k, Block(slice, slice + slice_bytes_));
      told_(double(begin) + double(end_ - begin) * double(z + count - first) / double(last - first));
    }
  }

  const std::byte* held(int z) override {
    const auto found = decoded_.find(z);
    return found == decoded_.end() ? nullptr : found->second.data();
  }

  VolumeSource* source_;  ///< null on a process that does not read
  int depth_, span_ = 1, group_ = 1;
  int end_ = 0;  ///< slices before it have been decoded by their readers
  std::function<void(double)> told_;
  std::map<int, Block> decoded_;  ///< slices that may still be needed
};

class StoredSupply final : public SendingSupply {
 public:
  StoredSupply(const Grid& grid, const std::map<int, SliceStore>& stores, const Sharing& sharing)
      : SendingSupply(grid, sharing.collectives), stores_(stores), dealing_(sharing.dealing) {}
  int available_from(int) override { return slices_; }

 private:
  const std::byte* held(int z) override {
    const auto store = stores_.find(dealing_.owner_of(z));
    return store == stores_.end() ? nullptr : store->second.slice(Axis::z, z).values;
  }

  const std::map<int, SliceStore>& stores_;
  SliceDealing dealing_;
};

/// Processes get the full slices of the reduced ones that they need, and reduce them.
class ReducingSupply final : public SliceSupply, VolumeSource {
 public:
  ReducingSupply(const Grid& grid, std::unique_ptr<SliceSupply> full, const Reduction& reduction)
      : grid_(grid),
        full_(std::move(full)),
        reduced_(reduced_source(*this, reduction)),
        reads_(*reduced_),
        reduction_(reduction),
        batch_(std::max(1, batch_of(grid) / reduction.factor)) {}

  int available_from(int z) override { return std::min(reduced_->grid().dims.z, z + batch_); }

  void hand_out(int first, int end, const Needed& needed) override {
    reads_.hand_out(first, end, needed);
    full_->hand_out(full_slices(first).first, full_slices(end - 1).second, [&](int process, int full) {
      for (int z = first; z < end; ++z)
        if (const auto [from, to] = full_slices(z); from <= full && full < to && needed(process, z))
          return true;
      return false;
    });
  }

  const std::byte* slice(int z) override { return reads_.slice(z); }

 private:
  // What is reduced: the full slices of the batch.
  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return true; }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    const std::size_t bytes = grid_.slice_bytes(Axis::z);
    for (int k = 0; k < count; ++k)
      std::memcpy(out.data() + std::size_t(k) * bytes, full_->slice(first + k), bytes);
  }

  /// First and end of the full slices that slice z is made of.
  std::pair<int, int> full_slices(int z) const {
    int first = z, last = z;
    if (!reduction_.prefilter) first = last = z * reduction_.factor;
    for (int factor = reduction_.factor; reduction_.prefilter && factor > 1; factor /= 2) {
      first = 2 * first - 1;
      last = 2 * last + 2;
    }
    return {std::clamp(first, 0, grid_.dims.z - 1), std::clamp(last, 0, grid_.dims.z - 1) + 1};
  }

  Grid grid_;  ///< of the full slices
  std::unique_ptr<SliceSupply> full_;
  std::unique_ptr<VolumeSource> reduced_;
  ReadingSupply reads_;
  Reduction reduction_;
  int batch_;
};

}  // namespace

int batch_of(const Grid& grid) {
  return std::max<int>(1, int(batch_bytes / std::max<std::size_t>(1, grid.slice_bytes(Axis::z))));
}

std::map<int, SliceStore> deal_slices(OpenedVolume& volume, const LoadOptions& options,
                                      const Sharing& sharing) {
  const bool alone = volume.concurrent && volume.layer_depth == 1;
  // Slices are read and dealt in turns.
  double read = 0, dealt = 0;
  const auto note = [&](double& slices, double end, bool in_step) {
    slices = end;
    if (options.told) options.told((alone ? dealt : 0.5 * (read + dealt)) / volume.grid.dims.z, in_step);
  };
  std::unique_ptr<SliceSupply> supply;
  if (alone)
    supply = std::make_unique<ReadingSupply>(*volume.source);
  else
    supply = std::make_unique<DecodingSupply>(
        volume, [&](double z) { note(read, z, false); }, sharing.collectives);
  note(read, 0, true);
  return deal_slices(volume.grid, *supply,
                     {options, sharing, nullptr, [&](int end) { note(dealt, end, true); }});
}

std::unique_ptr<SliceSupply> stored_supply(const Grid& grid, const std::map<int, SliceStore>& stores,
                                           const Reduction& reduction, const Sharing& sharing) {
  auto full = std::make_unique<StoredSupply>(grid, stores, sharing);
  if (reduction.factor == 1) return full;
  return std::make_unique<ReducingSupply>(grid, std::move(full), reduction);
}

}  // namespace ringsplat

#include "scene/decoded_slices.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace ringsplat {
namespace {

int slices_of(std::int64_t count) {
  return int(std::min<std::int64_t>(count, std::numeric_limits<int>::max()));
}

}  // namespace

DecodedSlices::DecodedSlices(VolumeSource* source, const Grid& grid, int layer_depth, int process,
                             int readers, int batch)
    : source_(source),
      slices_(grid.dims.z),
      depth_(layer_depth),
      process_(process),
      span_(slices_of(std::int64_t(layer_depth) *
                      std::max<std::int64_t>(1, batch / (std::int64_t(layer_depth) * readers)))),
      group_(slices_of(std::int64_t(span_) * readers)),
      slice_bytes_(grid.slice_bytes(Axis::z)) {}

void DecodedSlices::decode_group(int needed, const std::function<void(double z)>& told) {
  forget_before(needed);
  const std::int64_t begin = end_, first = begin + std::int64_t(process_) * span_;
  end_ = slices_of(std::min<std::int64_t>(slices_, begin + group_));
  const auto last = std::min<std::int64_t>(end_, first + span_);
  if (source_ == nullptr || first >= last) return;
  Run run{int(last - first), Block(std::size_t(last - first) * slice_bytes_)};
  for (std::int64_t z = first; z < last; z += depth_) {
    const auto count = std::min<std::int64_t>(depth_, last - z);
    source_->read_slices(
        int(z), int(count),
        std::span(run.voxels)
            .subspan(std::size_t(z - first) * slice_bytes_, std::size_t(count) * slice_bytes_));
    told(double(begin) + double(end_ - begin) * double(z + count - first) / double(last - first));
  }
  runs_.emplace(int(first), std::move(run));
}

const std::byte* DecodedSlices::find(int z) const {
  const auto behind = runs_.upper_bound(z);
  if (behind == runs_.begin()) return nullptr;
  const auto& [first, run] = *std::prev(behind);
  return z - first < run.count ? run.voxels.data() + std::size_t(z - first) * slice_bytes_ : nullptr;
}

void DecodedSlices::forget_before(int z) {
  std::map<int, Run> kept;
  for (const auto& [first, run] : runs_) {
    const int from = std::max(first, z), count = first + run.count - from;
    if (count <= 0) continue;
    const auto* begin = run.voxels.data() + std::size_t(from - first) * slice_bytes_;
    // A copy, because a vector that is cut keeps its memory.
    kept.emplace(from, Run{count, Block(begin, begin + std::size_t(count) * slice_bytes_)});
  }
  runs_ = std::move(kept);
}

}  // namespace ringsplat

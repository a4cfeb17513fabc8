#include "volume/read_ahead.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/process.hpp"

namespace ringsplat {

NotingSource::NotingSource(std::unique_ptr<VolumeSource> source, std::vector<SliceRun>& runs)
    : ForwardingSource(std::move(source)), runs_(runs), noted_(std::size_t(grid().dims.z)) {
  runs_.clear();
}

void NotingSource::read_slices(int first, int count, std::span<std::byte> out) {
  ForwardingSource::read_slices(first, count, out);
  const auto begin = noted_.begin() + first, end = begin + count;
  if (std::find(begin, end, false) == end) return;
  runs_.push_back({first, count});
  std::fill(begin, end, true);
}

ReadAheadSource::ReadAheadSource(std::unique_ptr<VolumeSource> source, std::vector<SliceRun> runs,
                                 std::size_t most_bytes)
    : ForwardingSource(std::move(source)),
      runs_(std::move(runs)),
      most_bytes_(most_bytes),
      slice_bytes_(grid().slice_bytes(Axis::z)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void ReadAheadSource::run(const std::stop_token& stop) {
  const PlainFloats as_without_a_thread;
  std::exception_ptr failure;
  try {
    std::size_t slices = 0;
    for (const SliceRun& run : runs_) {
      slices += std::size_t(run.count);
      if (stop.stop_requested() || slices * slice_bytes_ > most_bytes_) break;
      read(run);
    }
  } catch (...) {
    failure = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  failure_ = failure;
  ended_ = true;
  changed_.notify_all();
}

void ReadAheadSource::read(const SliceRun& run) {
  std::vector<std::byte> voxels(std::size_t(run.count) * slice_bytes_);
  ForwardingSource::read_slices(run.first, run.count, voxels);
  const std::lock_guard lock(mutex_);
  for (int k = 0; k < run.count; ++k) {
    const auto begin = voxels.begin() + std::ptrdiff_t(std::size_t(k) * slice_bytes_);
    slices_[run.first + k].assign(begin, begin + std::ptrdiff_t(slice_bytes_));
  }
  changed_.notify_all();
}

bool ReadAheadSource::has(int first, int count) const {
  for (int z = first; z < first + count; ++z)
    if (!slices_.contains(z)) return false;
  return true;
}

void ReadAheadSource::read_slices(int first, int count, std::span<std::byte> out) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return ended_ || has(first, count); });
  if (has(first, count)) {
    for (int k = 0; k < count; ++k)
      std::memcpy(out.data() + std::size_t(k) * slice_bytes_, slices_.at(first + k).data(), slice_bytes_);
    return;
  }
  if (failure_) std::rethrow_exception(failure_);
  ForwardingSource::read_slices(first, count, out);
}

}  // namespace ringsplat

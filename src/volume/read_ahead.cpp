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
      thread_([this] { run(); }) {}

ReadAheadSource::~ReadAheadSource() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void ReadAheadSource::run() {
  const PlainFloats as_without_a_thread;
  std::unique_lock lock(mutex_);
  while (next_ < runs_.size() && !stop_ && !failure_) {
    no_room_ = !make_room(runs_[next_]);
    changed_.notify_all();
    if (no_room_)
      changed_.wait(lock);
    else
      read_next(lock);
  }
  changed_.notify_all();
}

/// The mutex is not held while the source is read.
void ReadAheadSource::read_next(std::unique_lock<std::mutex>& lock) {
  const SliceRun& run = runs_[next_];
  lock.unlock();
  std::exception_ptr failure;
  std::map<int, Slice> slices;
  try {
    std::vector<std::byte> voxels(std::size_t(run.count) * slice_bytes_);
    read_source(run.first, run.count, voxels);
    for (int k = 0; k < run.count; ++k) {
      const auto begin = voxels.begin() + std::ptrdiff_t(std::size_t(k) * slice_bytes_);
      slices[run.first + k].voxels.assign(begin, begin + std::ptrdiff_t(slice_bytes_));
    }
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  failure_ = failure;
  if (!failure) ++next_;
  slices_.merge(slices);
}

void ReadAheadSource::read_source(int first, int count, std::span<std::byte> out) {
  const std::lock_guard lock(source_mutex_);
  ForwardingSource::read_slices(first, count, out);
}

/// Forgets slices that were asked for, where others need their room. The mutex is held.
bool ReadAheadSource::make_room(const SliceRun& run) {
  const auto fits = [&] {
    return slices_.empty() || (slices_.size() + std::size_t(run.count)) * slice_bytes_ <= most_bytes_;
  };
  for (auto slice = slices_.begin(); slice != slices_.end() && !fits();)
    slice = slice->second.asked_for ? slices_.erase(slice) : std::next(slice);
  return fits();
}

bool ReadAheadSource::has(int first, int count) const {
  for (int z = first; z < first + count; ++z)
    if (!slices_.contains(z)) return false;
  return true;
}

/// The mutex is held.
bool ReadAheadSource::will_have(int first, int count) const {
  if (failure_ || no_room_) return false;
  for (int z = first; z < first + count; ++z) {
    const auto reads_it = [z](const SliceRun& run) { return z >= run.first && z < run.first + run.count; };
    const auto rest = runs_.begin() + std::ptrdiff_t(next_);
    if (!slices_.contains(z) && std::find_if(rest, runs_.end(), reads_it) == runs_.end()) return false;
  }
  return true;
}

/// The mutex is held.
void ReadAheadSource::give(int first, int count, std::span<std::byte> out) {
  for (int k = 0; k < count; ++k) {
    Slice& slice = slices_.at(first + k);
    std::memcpy(out.data() + std::size_t(k) * slice_bytes_, slice.voxels.data(), slice_bytes_);
    slice.asked_for = true;
  }
  no_room_ = false;  // as far as is known
  changed_.notify_all();
}

void ReadAheadSource::read_slices(int first, int count, std::span<std::byte> out) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return has(first, count) || !will_have(first, count); });
  if (has(first, count)) return give(first, count, out);
  if (failure_) std::rethrow_exception(failure_);
  // The thread waits for room, or has ended.
  if (next_ < runs_.size() && runs_[next_] == SliceRun{first, count}) ++next_;
  changed_.notify_all();
  lock.unlock();
  read_source(first, count, out);
}

}  // namespace ringsplat

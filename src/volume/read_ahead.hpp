#pragma once
#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <cstring>
#include <exception>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "base/process.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat {

/// z slices [first, first + count) that are read by one call.
struct SliceRun {
  int first = 0, count = 0;
  bool operator==(const SliceRun&) const = default;
};

/// Notes what is read of a source, each slice once, in order: what will be read of the next volume of a
/// series.
class NotingSource final : public ForwardingSource {
 public:
  /// `runs`, which is cleared, must outlive the source.
  NotingSource(std::unique_ptr<VolumeSource> source, std::vector<SliceRun>& runs)
      : ForwardingSource(std::move(source)), runs_(runs), noted_(std::size_t(grid().dims.z)) {
    runs_.clear();
  }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    ForwardingSource::read_slices(first, count, out);
    const auto begin = noted_.begin() + first, end = begin + count;
    if (std::find(begin, end, false) == end) return;
    runs_.push_back({first, count});
    std::fill(begin, end, true);
  }

 private:
  std::vector<SliceRun>& runs_;
  std::vector<bool> noted_;  ///< by slice
};

/// Reads `runs` of a source into memory on a thread of its own, which begins at once and calls no MPI, until
/// all are read or another one would take more than `most_bytes`. read_slices() gives what is there and waits
/// for the rest; what the thread left out it reads itself. An error of the thread is thrown where its slices
/// are asked for. Its end waits for the run that is being read and gives up the others.
class ReadAheadSource final : public ForwardingSource {
 public:
  ReadAheadSource(std::unique_ptr<VolumeSource> source, std::vector<SliceRun> runs, std::size_t most_bytes)
      : ForwardingSource(std::move(source)),
        runs_(std::move(runs)),
        most_bytes_(most_bytes),
        slice_bytes_(grid().slice_bytes(Axis::z)),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}
  void read_slices(int first, int count, std::span<std::byte> out) override {
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

 private:
  void run(const std::stop_token& stop) {
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
  void read(const SliceRun& run) {
    std::vector<std::byte> voxels(std::size_t(run.count) * slice_bytes_);
    ForwardingSource::read_slices(run.first, run.count, voxels);
    const std::lock_guard lock(mutex_);
    for (int k = 0; k < run.count; ++k) {
      const auto begin = voxels.begin() + std::ptrdiff_t(std::size_t(k) * slice_bytes_);
      slices_[run.first + k].assign(begin, begin + std::ptrdiff_t(slice_bytes_));
    }
    changed_.notify_all();
  }
  bool has(int first, int count) const {
    for (int z = first; z < first + count; ++z)
      if (!slices_.contains(z)) return false;
    return true;
  }

  const std::vector<SliceRun> runs_;
  const std::size_t most_bytes_, slice_bytes_;
  std::mutex mutex_;  ///< guards what follows; the source is the thread's until that has ended
  std::condition_variable changed_;
  std::map<int, std::vector<std::byte>> slices_;
  bool ended_ = false;
  std::exception_ptr failure_;
  std::jthread thread_;  ///< last: it uses all of the above
};

}  // namespace ringsplat

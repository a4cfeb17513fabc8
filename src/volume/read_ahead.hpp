#pragma once
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

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
  NotingSource(std::unique_ptr<VolumeSource> source, std::vector<SliceRun>& runs);
  void read_slices(int first, int count, std::span<std::byte> out) override;

 private:
  std::vector<SliceRun>& runs_;
  std::vector<bool> noted_;  ///< by slice
};

/// Reads `runs` of a source into memory on a thread of its own, which begins at once and calls no MPI. It
/// holds at most `most_bytes`, or one run; slices that were asked for make room for others. read_slices()
/// gives what is there, waits for what is being read or will be, and reads all else itself. An error of the
/// thread is thrown where its slices are asked for.
///
/// The source is used by one thread at a time. finish() waits until the thread reads no more.
class ReadAheadSource final : public ForwardingSource {
 public:
  ReadAheadSource(std::unique_ptr<VolumeSource> source, std::vector<SliceRun> runs, std::size_t most_bytes);
  /// Gives up what is not yet read; waits for the run that is being read.
  ~ReadAheadSource() override;
  ReadAheadSource(const ReadAheadSource&) = delete;
  ReadAheadSource& operator=(const ReadAheadSource&) = delete;

  void read_slices(int first, int count, std::span<std::byte> out) override;

 private:
  struct Slice {
    std::vector<std::byte> voxels;
    bool asked_for = false;
  };
  void run();
  void read_next(std::unique_lock<std::mutex>& lock);
  void read_source(int first, int count, std::span<std::byte> out);
  bool make_room(const SliceRun& run);
  bool has(int first, int count) const;
  bool will_have(int first, int count) const;
  void give(int first, int count, std::span<std::byte> out);

  const std::vector<SliceRun> runs_;
  const std::size_t most_bytes_, slice_bytes_;
  std::mutex source_mutex_;
  std::mutex mutex_;  ///< guards what follows
  std::condition_variable changed_;
  std::map<int, Slice> slices_;
  std::size_t next_ = 0;  ///< into runs_
  bool no_room_ = false;  ///< the thread waits for some
  bool stop_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace ringsplat

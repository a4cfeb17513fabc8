#pragma once
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <map>
#include <mutex>
#include <stop_token>
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

/// Reads `runs` of a source into memory on a thread of its own, which begins at once and calls no MPI, until
/// all are read or another one would take more than `most_bytes`. read_slices() gives what is there and waits
/// for the rest; what the thread left out it reads itself. An error of the thread is thrown where its slices
/// are asked for. Its end waits for the run that is being read and gives up the others.
class ReadAheadSource final : public ForwardingSource {
 public:
  ReadAheadSource(std::unique_ptr<VolumeSource> source, std::vector<SliceRun> runs, std::size_t most_bytes);
  void read_slices(int first, int count, std::span<std::byte> out) override;

 private:
  void run(const std::stop_token& stop);
  void read(const SliceRun& run);
  bool has(int first, int count) const;

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

#pragma once
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <string>
#include <utility>

#include "app/stats_output.hpp"
#include "base/process.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "session/director.hpp"

namespace ringsplat::app {

/// A frame, the file that its picture goes to, and the volume that it shows.
struct FinishedFrame {
  FrameResult result;
  std::filesystem::path file;
  std::string volume;
  ValueRange range;  ///< of its values
  bool whole;        ///< no better picture of the view comes
  RefinementSteps refinements;
};

/// Writes finished frames on threads of their own, one after another in the order they come, so that encoding
/// pictures delays neither the frame buffer nor its rank's other nodes. Never calls MPI: only one thread of a
/// rank does.
class FrameWriter {
 public:
  /// Frames that may wait, besides the one that is being written.
  static constexpr std::size_t room = 2;

  /// What `write` refers to must outlive this object, which waits until all frames are written or writing has
  /// failed; others may touch it only after finish().
  explicit FrameWriter(std::function<void(FinishedFrame&&)> write) : write_(std::move(write)) {}

  /// Waits while there is no room. Throws what writing an earlier frame threw; nothing is written after it.
  void put(FinishedFrame&& frame) {
    if (unfinished_.size() > room) wait_for_first();
    std::shared_future<void> before;
    if (!unfinished_.empty()) before = unfinished_.back();
    unfinished_.push_back(std::async(std::launch::async, [this, before = std::move(before),
                                                          frame = std::move(frame)]() mutable {
                            if (before.valid()) std::exchange(before, {}).get();
                            // Same as on the rendering thread, so that a file's bytes do not depend on the
                            // thread that writes it.
                            flush_denormals();
                            write_(std::move(frame));
                          }).share());
  }
  /// Returns when all frames are written; throws what writing one of them threw. Nothing can be put after it.
  void finish() {
    while (!unfinished_.empty()) wait_for_first();
  }

 private:
  void wait_for_first() {
    const std::shared_future<void> first = std::move(unfinished_.front());
    unfinished_.pop_front();
    first.get();
  }

  const std::function<void(FinishedFrame&&)> write_;
  std::deque<std::shared_future<void>> unfinished_;  ///< each waits for the one before it
};

}  // namespace ringsplat::app

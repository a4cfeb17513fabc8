#pragma once
#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "app/stats_output.hpp"
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

/// A thread that writes finished frames in the order they come, so that encoding pictures delays neither the
/// frame buffer nor its rank's other nodes. Starts with the first frame. Never calls MPI: only one thread of
/// a rank does.
class FrameWriter {
 public:
  /// Frames that may wait, besides the one that is being written.
  static constexpr std::size_t room = 2;

  /// `write` runs on the thread. What it refers to must outlive this object; others may touch it only after
  /// finish().
  explicit FrameWriter(std::function<void(FinishedFrame&&)> write);
  /// Writes the frames that still wait, unless writing has failed.
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  /// Waits while there is no room. Throws what writing an earlier frame threw; nothing is written after it.
  void put(FinishedFrame&& frame);
  /// Returns when all frames are written; throws what writing one of them threw. Nothing can be put after it.
  void finish();

 private:
  void run();
  void end();

  const std::function<void(FinishedFrame&&)> write_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<FinishedFrame> waiting_;
  std::exception_ptr failure_;
  bool no_more_ = false;
  std::thread thread_;
};

}  // namespace ringsplat::app

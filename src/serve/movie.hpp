#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "ringsplat/base/bytes.hpp"
#include "serve/private_folder.hpp"

namespace ringsplat::serve {

/// What all frames of a movie have in common.
struct MoviePlan {
  int count = 1;                ///< of frames
  double frames_a_second = 25;  ///< that it is shown with
  int width = 0, height = 0;
  bool operator==(const MoviePlan&) const = default;
};

/// A movie that is being made: its frames as PNGs in a folder of its own, which nobody else can read and
/// which is gone with this object, until ffmpeg makes a file of them. add() and encode() for one thread at a
/// time, never one that calls MPI, as they may take long.
class Movie {
 public:
  using Clock = std::chrono::steady_clock;

  /// Makes the folder, below TMPDIR. Throws RunError when it cannot.
  Movie(std::filesystem::path ffmpeg, const MoviePlan& plan);

  const MoviePlan& plan() const { return plan_; }
  const std::filesystem::path& folder() const { return folder_.path(); }

  /// Keeps frame `index`. Throws RunError when the disk is full, or its share of it.
  void add(int index, const Bytes& png);
  /// The MP4 of all frames: H.264 if ffmpeg has libx264, else MPEG-4; 4:2:0, so with an even width and
  /// height: a black row or column is added where they are not. Throws RunError when ffmpeg fails or takes
  /// until the deadline.
  std::string encode(Clock::time_point deadline);
  /// What a movie of that many pixels may take to encode.
  std::chrono::milliseconds patience() const;

  /// Ends encode() soon; for any thread.
  void cancel() { cancelled_ = true; }
  bool cancelled() const { return cancelled_; }

 private:
  const std::filesystem::path ffmpeg_;
  const MoviePlan plan_;
  PrivateFolder folder_;
  std::uintmax_t bytes_left_ = 0;  ///< for frames
  std::atomic<bool> cancelled_ = false;
};

}  // namespace ringsplat::serve

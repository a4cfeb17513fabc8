#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "app/measured_error.hpp"
#include "app/options.hpp"
#include "app/progress.hpp"
#include "ringsplat/node/frame_buffer.hpp"
#include "ringsplat/volume/statistics.hpp"

namespace ringsplat::app {

/// What --stats says of memory beforehand.
struct SliceMemory {
  std::array<bool, 3> kept_axes{};
  std::vector<std::uint64_t> predicted;  ///< bytes of slices by GP
};

/// Where finished frames go: pictures, a line of results each, and the statistics file at the end. Lives on
/// rank 0.
class FrameOutput {
 public:
  /// All that is passed by reference must outlive it.
  FrameOutput(const RenderOptions& options, const Layout& layout, const ValueRange& range, SliceMemory memory,
              std::vector<std::filesystem::path> files, Progress& progress);

  /// Writes the picture, or keeps it until finish() when its error is to be measured: a truth takes longer
  /// than other ranks should wait.
  void take(FrameResult&& result);
  /// Writes --stats and prints the summary.
  void finish();

 private:
  void write(const FrameResult& result, const MeasuredError* error);
  void measure_kept();
  std::string stats_text() const;

  const RenderOptions& options_;
  const Layout& layout_;
  const ValueRange& range_;
  SliceMemory memory_;
  std::vector<std::filesystem::path> files_;
  Progress& progress_;
  std::vector<FrameResult> kept_;  ///< whose error is to be measured
  std::vector<double> seconds_;
  std::vector<std::string> stats_;  ///< one JSON object a frame
  int empty_frames_ = 0;
};

/// The views of a run's frames: one, an orbit or a path. Throws InputError for a path that cannot be read.
std::vector<Camera> views_of(const RenderOptions& options);

/// The files of a run's frames: the output itself, or numbered ones when there may be more than one.
std::vector<std::filesystem::path> output_files(const RenderOptions& options, std::size_t frames);

}  // namespace ringsplat::app

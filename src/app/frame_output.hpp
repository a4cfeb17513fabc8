#pragma once
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/channels.hpp"
#include "base/process.hpp"
#include "images/drawing.hpp"
#include "options/options.hpp"
#include "program/progress.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "serve/movie.hpp"
#include "session/render_frames.hpp"
#include "study/error_budget.hpp"

namespace ringsplat::app {

/// A frame, the file that its picture goes to, and the volume that it shows.
struct FinishedFrame {
  FrameResult result;
  std::filesystem::path file;
  std::string volume;
  ValueRange range;  ///< of its values
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

bool names_film(const std::filesystem::path& output);
/// Throws InputError for a run that makes no film, and where there is no ffmpeg.
void check_film(const RenderOptions& options);

class Launch;
class StatsOutput;
struct Job;

/// Outputs finished frames: pictures, a line of results each, and statistics. Lives on rank 0 and writes on a
/// thread of its own.
class FrameOutput {
 public:
  /// `range`: of the first volume's values. What is passed by reference must outlive it.
  FrameOutput(const Job& job, const ValueRange& range, Progress& progress);
  ~FrameOutput();

  /// Has the picture written; its frame's number counts views. When its error is to be measured it keeps the
  /// picture until finish(), as a truth takes too long for frames to wait. Throws RunError when an
  /// earlier picture could not be written.
  void take(FrameResult&& result);
  /// The next frames show another volume of a series.
  void show(const std::string& volume, const ValueRange& range);
  /// Measures the kept pictures that were not measured yet. All ranks call it; the result is rank 0's.
  std::vector<Judged> judge(Launch& launch);
  /// Takes the place of a kept picture that was drawn for the frame with the same number.
  void replace(FrameResult&& result);
  /// Waits for the last picture, completes --stats and prints the summary. Throws RunError when something
  /// cannot be written.
  void finish();
  /// Has ffmpeg make the film, where -o names one. Takes long: after finish(), when no rank waits any more.
  /// Throws RunError when ffmpeg fails or the file cannot be written; a file that had the name is then still
  /// there.
  void make_film();

 private:
  /// A frame whose error is to be measured, or was.
  struct KeptFrame {
    FinishedFrame frame;
    std::optional<MeasuredError> error = std::nullopt;
    std::string of_level = {};  ///< what level_error() said
  };

  /// Warns of the first frame of a kind and counts them.
  void warn(const std::string& label, const std::string& why, int& frames);
  void write(const FinishedFrame& frame, const MeasuredError* error);
  void add_to_film(const Image& image, const Overlay& overlay);

  const Job& job_;
  const RenderOptions& options_;  ///< the job's
  std::string volume_;            ///< path of the volume that is shown
  ValueRange range_;
  std::optional<serve::Movie> film_;  ///< -o FILM.mp4, once it has a picture
  Progress& progress_;
  std::vector<KeptFrame> kept_;
  std::vector<double> seconds_;
  double period_sum_ = 0;
  std::unique_ptr<StatsOutput> stats_;
  int empty_frames_ = 0, nearly_empty_frames_ = 0;
  FrameWriter writer_;  ///< declared last: it uses all of the above
};

/// What it costs, in a line, to show a pyramid's level instead of the finest: their fields' difference, as
/// dense in world lengths, in the middle of what is shown, of which the finest takes as doubles at most
/// --memory, or 128 MiB; it alone is read. Empty where `shown` is the finest.
std::string level_error(const Image& picture, const truth::Scene& shown, const RenderOptions& options);

/// The settings that decide the picture, and the volume's name, as JSON; the same bytes for any number of
/// ranks. `channels`: that were added; the frame's function is then of none.
std::string picture_settings(const FrameSpec& spec, const std::string& volume, bool annotated,
                             const std::vector<DrawnChannel>& channels, const MeasuredError* error = nullptr);

/// Why a drawn picture shows nothing, or hardly anything; else empty. `range`: the volume's.
std::string why_empty(const FrameResult& result, const ValueRange& range);
std::string why_nearly_empty(const FrameResult& result);

/// The file of a view's picture: `name` itself, -o or --error-map, or a numbered file when there may be
/// several. `view` counts from 0.
std::filesystem::path file_of_view(const RenderOptions& options, const std::string& name, std::size_t view);

}  // namespace ringsplat::app

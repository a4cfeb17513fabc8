#pragma once
#include <optional>
#include <vector>

#include "options/options.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "session/render_frames.hpp"
#include "study/error_budget.hpp"

namespace ringsplat::app {

/// Of the run's views two for each slice set that they traverse: the straightest, where all slices err in the
/// same places, and the most oblique.
std::vector<Camera> calibration_views(const std::vector<Camera>& run, FrameSpec frame, const Grid& grid);

/// Measures time and error of each setting. It renders every view once to choose the pixels at which to
/// evaluate the truth (`error.truth`: the reference's method's unless it says another), then every view with
/// each setting in turn: as often as some seconds allow, at most three times. Rank 0 only.
class Calibration {
 public:
  /// Reads the volume. Throws InputError as read_whole does.
  Calibration(const FrameSpec& reference, std::vector<Camera> views, std::vector<Shortcuts> settings,
              const VolumeOptions& volume, const ErrorOptions& error);

  /// Run it with one frame in flight, so that a frame's time is its own. It refers to this object.
  Director director();

  std::size_t frames() const { return frames_done_; }
  /// Call it when the director has no more frames.
  std::vector<MeasuredShortcuts> measured() const;

 private:
  struct Measurements {
    std::vector<double> seconds;
    truth::SampledError error;
  };

  /// Each setting draws a view twice: at first it makes what it needs of the slices.
  std::size_t frames_a_pass() const { return 2 * views_.size() * settings_.size(); }
  /// The frames before the first measured one: each view as the reference, and the first view once more.
  std::size_t first_measured() const { return views_.size() + 1; }
  std::optional<FrameSpec> next_frame();
  void take(FrameResult&& result);
  void evaluate_truths();

  FrameSpec reference_;
  std::vector<Camera> views_;
  std::vector<Shortcuts> settings_;
  ErrorOptions error_;
  truth::Scene scene_;                      ///< until the truths are known
  std::vector<Image> pictures_;             ///< the reference's, by view, until the truths are known
  std::vector<SampledTruth> truths_;        ///< by view
  std::vector<Measurements> measurements_;  ///< by view, then setting
  std::size_t frames_asked_ = 0, frames_done_ = 0;
  double started_ = 0;
};

}  // namespace ringsplat::app

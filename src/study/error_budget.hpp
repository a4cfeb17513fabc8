#pragma once
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "options/options.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "truth/sampling.hpp"
#include "truth/scene.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat::app {

/// What an error budget may trade for speed (docs/accuracy.md, "An error budget").
struct Shortcuts {
  double opaque_threshold = 0;
  Sheets how;
  int undersample = 1;
  bool operator==(const Shortcuts&) const = default;
};

/// The frame as `shortcuts` would render it.
FrameSpec with(FrameSpec frame, const Shortcuts& shortcuts);

/// Undersampling factors among the candidates when the user has fixed none.
inline constexpr std::array undersampling{1, 2, 4};

/// The command-line options that set these shortcuts.
std::string to_text(const Shortcuts& shortcuts);

/// What to choose from, as it was asked for first. Settings that the user has fixed stay as in
/// `frame`, which must be of sheets: splats seldom keep a budget in less time (docs/measured/accuracy.md,
/// "Error budgets").
std::vector<Shortcuts> candidates(const FrameSpec& frame, const ErrorBudgetOptions& options);

struct MeasuredShortcuts {
  Shortcuts shortcuts;
  double seconds = 0;              ///< a frame: mean over the views of each view's median
  double rmse = 0, rmse_high = 0;  ///< the worst view's, in 1/255; upper end of the 95 % interval
};

/// A picture and its measured error.
struct Judged {
  FrameSpec spec;
  std::string name;
  double error;  ///< what a budget is held by, in 1/255
};

/// Index of the cheapest setting whose interval's upper end is within `max_error`. Times within 3 % of the
/// least count as equal, which is how well they are measured; among those the least error wins. Nothing when
/// none keeps the budget.
std::optional<std::size_t> cheapest_within(std::span<const MeasuredShortcuts> measured, double max_error);

/// Index of the setting with the least upper end, the fastest among equals. `measured` must not be empty.
std::size_t most_exact(std::span<const MeasuredShortcuts> measured);

/// What to draw a picture with that errs `rmse` with `used`, more than `max_error`: of the more exact
/// settings the cheapest within the budget, should all err as much more than measured as this one; the most
/// exact where there is none, and at the `last` attempt. Nothing when `used` is the most exact.
std::optional<Shortcuts> more_exact(std::span<const MeasuredShortcuts> measured, const Shortcuts& used,
                                    double rmse, double max_error, bool last);

/// A whole volume in one process, as truths need it: 8 bytes a voxel. It is read once for many frames, which
/// the scene's owner sets.
struct WholeVolume {
  truth::Scene scene;
  ValueStatistics statistics;       ///< the same as load_scene's, so that presets are the same
  std::vector<double> labels = {};  ///< of its segmentation but 0, each once, ascending
};
/// Throws InputError when the volume is unreadable or exceeds this machine's memory.
WholeVolume read_whole(VolumeSource& source);

struct Evaluation {
  TruthKind truth = TruthKind::field;
  double tolerance = 1e-6;
  std::string formula = {};
};
/// `certified`: the middle of the bounds.
std::vector<truth::Rgba> evaluate(const truth::Scene& scene, const Evaluation& evaluation,
                                  std::span<const truth::Pixel> pixels);

/// Processes that evaluate a truth together: each takes its share of the pixels, and all get all.
struct Crew {
  std::size_t member = 0, members = 1;
  /// Runs `work` and returns what it returned on each member; throws on all the InputError that one throws.
  /// Null: this process is alone.
  std::function<std::vector<Bytes>(const std::function<Bytes()>& work)> exchange = {};
};

/// A sample of a picture's pixels and the truth there; it serves other pictures of the scene, too.
struct SampledTruth {
  truth::PixelSample sample;
  std::vector<truth::Rgba> colours;
};
/// Samples where `picture` differs most (truth::draw_sample) and evaluates the truth there.
SampledTruth sample_truth(const Image& picture, const truth::Scene& scene, const Evaluation& evaluation,
                          std::size_t pixels, std::uint64_t seed, const Crew& crew = {});

/// What bounds of the field's integral prove of the pixels looked at, in 1/255.
struct Certificate {
  double least = 0;                ///< of the largest error
  double widest = 0;               ///< of the bounds
  std::array<double, 3> proved{};  ///< the shares of pixels that err at most as much as `limits`
  static constexpr std::array<double, 3> limits{0.5, 1, 2};
  std::optional<std::size_t> replaced = std::nullopt;  ///< pixels, to keep a guarantee, by bounds' middles
};

struct MeasuredError {
  TruthKind truth;
  std::uint64_t seed;
  truth::SampledError error;
  double seconds;  ///< spent on the truth
  /// Then `error.largest` and, of all pixels, `error.rmse_high` are surely not exceeded.
  std::optional<Certificate> certificate = std::nullopt;
  std::vector<float> by_pixel = {};  ///< truth::sampled_error's
  /// What a budget is held by: RMSE, or what a guarantee is of, the largest error.
  double held() const {
    if (!certificate) return error.rmse;
    return certificate->replaced ? error.largest : error.rmse_high;
  }
};
/// Settings are compared by estimates, also where pictures are then certified.
TruthKind calibrating_truth(const ErrorOptions& options);
/// Changes the picture only where options ask for a guarantee. All of a crew make the call, with the same
/// picture and scene, and get the same.
MeasuredError measure(Image& image, const truth::Scene& scene, const ErrorOptions& options,
                      const Crew& crew = {});

/// "error against the method's truth: 0.0021/255 rms (95 %: 0.0019 to 0.0023), …".
std::string to_text(const MeasuredError& error);

}  // namespace ringsplat::app

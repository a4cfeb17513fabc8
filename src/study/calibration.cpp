#include "study/calibration.hpp"

#include "base/clock.hpp"
#include "base/median.hpp"

namespace ringsplat::app {

std::vector<Camera> calibration_views(const std::vector<Camera>& run, FrameSpec frame, const Grid& grid) {
  struct Outermost {
    double cos_angle;
    std::size_t view;
  };
  std::map<Axis, std::pair<Outermost, Outermost>> by_axis;  // the most oblique and the straightest
  for (std::size_t k = 0; k < run.size(); ++k) {
    frame.shown.camera = run[k];
    const Traversal t = make_geometry(frame, grid).traversal;
    const Outermost here{t.cos_angle, k};
    auto& [oblique, straight] = by_axis.try_emplace(t.axis, here, here).first->second;
    if (t.cos_angle < oblique.cos_angle) oblique = here;
    if (t.cos_angle > straight.cos_angle) straight = here;
  }
  std::set<std::size_t> chosen;
  for (const auto& [axis, both] : by_axis) chosen.insert({both.first.view, both.second.view});
  std::vector<Camera> views;
  for (const std::size_t k : chosen) views.push_back(run[k]);
  return views;
}

Calibration::Calibration(const FrameSpec& reference, std::vector<Camera> views,
                         std::vector<Shortcuts> settings, const VolumeOptions& volume,
                         const ErrorOptions& error)
    : reference_(reference),
      views_(std::move(views)),
      settings_(std::move(settings)),
      error_(error),
      scene_(read_whole(*open_volume(volume)).scene),
      measurements_(views_.size() * settings_.size()) {}

Director Calibration::director() {
  return {[this] { return next_frame(); }, [this](FrameResult&& result) { take(std::move(result)); }};
}

/// The first frames are not measured, since they still allocate. A result may come one frame late
/// (FrameBuffer): the last of them makes sure that all pictures have come, so that no frame is timed while
/// truths are evaluated.
std::optional<FrameSpec> Calibration::next_frame() {
  const std::size_t asked = frames_asked_;
  if (asked < first_measured()) {
    ++frames_asked_;
    FrameSpec frame = reference_;
    frame.shown.camera = views_[asked % views_.size()];
    return frame;
  }
  if (asked == first_measured()) {
    evaluate_truths();
    started_ = now_seconds();
  }
  constexpr std::size_t most_passes = 3;
  constexpr double patience = 5;  // seconds after which no further pass is begun
  const std::size_t at = asked - first_measured();
  const std::size_t pass = at / frames_a_pass(), in_pass = at % frames_a_pass();
  if (in_pass == 0 && pass > 0 && (pass == most_passes || now_seconds() - started_ > patience))
    return std::nullopt;
  ++frames_asked_;
  FrameSpec frame = with(reference_, settings_[in_pass / 2 % settings_.size()]);
  frame.shown.camera = views_[in_pass / 2 / settings_.size()];
  return frame;
}

void Calibration::evaluate_truths() {
  for (std::size_t v = 0; v < views_.size(); ++v) {
    reference_.shown.camera = views_[v];
    scene_.frame = reference_;
    truths_.push_back(
        sample_truth(pictures_[v], scene_, {.truth = calibrating_truth(error_)}, error_.pixels, error_.seed));
  }
  scene_ = {};
  pictures_.clear();
}

void Calibration::take(FrameResult&& result) {
  const std::size_t frame = frames_done_++;
  if (frame < views_.size()) pictures_.push_back(std::move(result.image));
  if (frame < first_measured()) return;
  const std::size_t in_pass = (frame - first_measured()) % frames_a_pass();
  Measurements& m = measurements_[in_pass / 2];
  if (in_pass % 2 == 0) return;
  if (m.seconds.empty()) {
    const SampledTruth& truth = truths_[in_pass / 2 / settings_.size()];
    m.error = truth::sampled_error(result.image, truth.sample, truth.colours);
  }
  m.seconds.push_back(result.stats.seconds);
}

std::vector<MeasuredShortcuts> Calibration::measured() const {
  std::vector<MeasuredShortcuts> all;
  for (std::size_t s = 0; s < settings_.size(); ++s) {
    MeasuredShortcuts sum{settings_[s]};
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const Measurements& m = measurements_[v * settings_.size() + s];
      sum.seconds += median(m.seconds) / double(views_.size());
      sum.rmse = std::max(sum.rmse, m.error.rmse);
      sum.rmse_high = std::max(sum.rmse_high, m.error.rmse_high);
    }
    all.push_back(sum);
  }
  return all;
}

}  // namespace ringsplat::app

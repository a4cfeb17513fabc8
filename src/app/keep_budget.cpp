#include <memory>

#include "app/render_job.hpp"
#include "base/clock.hpp"
#include "base/log.hpp"
#include "study/calibration.hpp"

namespace ringsplat::app {
namespace {

/// The hint: what to change for more exactness.
std::string hint_for(const ErrorBudgetOptions& o, const FrameSpec& frame, double best) {
  std::vector<std::string> fixed;
  const auto note = [&](const char* option, bool coarse) {
    if (coarse && o.fixed.contains(option)) fixed.emplace_back(option);
  };
  note("--opaque-threshold", frame.shown.opaque_threshold > 0);
  note("--undersample", frame.shown.reduction.factor > 1);
  const auto& how = frame.as<Sheets>();
  note("--image-plane", how.image_plane == ImagePlane::slices);
  note("--slabs", how.slabs < Sheets::most_slabs);
  note("--light-points", how.light_points < 2);
  const std::string larger = fmt::format("allow --max-error {:.2g}", 1.1 * best);
  return fixed.empty() ? larger : fmt::format("leave out {}, or {}", joined(fixed, " and "), larger);
}

MeasuredShortcuts choose(const std::vector<MeasuredShortcuts>& measured, const ErrorBudgetOptions& o,
                         const FrameSpec& frame) {
  if (const auto chosen = cheapest_within(measured, *o.max_error)) return measured[*chosen];
  const MeasuredShortcuts& best = measured[most_exact(measured)];
  if (o.guarantee) return best;
  throw InputError(fmt::format("this scene cannot keep --max-error {:g}: the most exact setting, {}, has "
                               "{:.3g}/255 rms (95 %: up to {:.3g})",
                               *o.max_error, to_text(best.shortcuts), best.rmse, best.rmse_high),
                   hint_for(o, frame, best.rmse_high));
}

/// Draws these frames, which keep their numbers.
void draw_again(Job& job, const std::vector<FrameSpec>& frames, const Gallery& gallery, Progress& progress,
                Launch& launch) {
  Scene scene = reload(job, progress, launch);
  const auto take = [&](FrameResult&& result) {
    result.spec.frame = result.stats.frame = frames[std::size_t(result.spec.frame)].frame;
    gallery.replace(std::move(result));
  };
  progress.begin("rendering", double(frames.size()));
  render_all(job, job.options.run.protocol, std::move(scene), director_of(frames, take), launch);
  progress.end();
}

}  // namespace

void keep_budget(Job& job, Scene& scene, FrameSpec& frame, Progress& progress, Launch& launch) {
  const RenderOptions& o = job.options;
  const auto settings = candidates(frame, o.budget);
  progress.begin("calibrating", 0);
  const double start = now_seconds();
  std::unique_ptr<Calibration> calibration;  // on rank 0
  launch.check_on_rank_0([&] {
    calibration = std::make_unique<Calibration>(frame, calibration_views(job.cameras, frame, scene.grid),
                                                settings, o.volume, o.error);
  });
  ProtocolOptions protocol = o.run.protocol;
  protocol.frames_in_flight = 1;
  render_all(job, protocol, std::move(scene), calibration ? calibration->director() : Director{}, launch);
  progress.end();
  launch.check_on_rank_0([&] {
    job.measured = calibration->measured();
    progress.print(fmt::format("calibrated {} settings: {} frames in {:.1f} s", settings.size(),
                               calibration->frames(), now_seconds() - start));
    const MeasuredShortcuts chosen = choose(job.measured, o.budget, frame);
    frame = with(frame, chosen.shortcuts);
    progress.print(fmt::format(
        "{}: {:.3g}/255 rms (95 %: up to {:.3g}), {:.4f} s a frame; the most exact setting {:.4f} s",
        to_text(chosen.shortcuts), chosen.rmse, chosen.rmse_high, chosen.seconds,
        job.measured[most_exact(job.measured)].seconds));
  });
  scene = reload(job, progress, launch);
}

bool hold_budget(Job& job, const Gallery& gallery, Progress& progress, Launch& launch) {
  constexpr int attempts = 2;
  const double budget = *job.options.budget.max_error;
  bool held = true;
  for (int attempt = 1;; ++attempt) {
    std::vector<FrameSpec> again;
    const std::vector<Judged> judged = gallery.judge();
    launch.check_on_rank_0([&] {
      for (const auto& [spec, name, error] : judged) {
        if (error <= budget) continue;
        const Shortcuts used{spec.shown.opaque_threshold, spec.as<Sheets>(), spec.shown.reduction.factor};
        std::optional<Shortcuts> other;
        if (attempt <= attempts && !job.options.budget.guarantee)
          other = more_exact(job.measured, used, error, budget, attempt == attempts);
        if (other) {
          progress.print(
              fmt::format("{}: {:.3g}/255 rms, so it is drawn again with {}", name, error, to_text(*other)));
          again.push_back(with(spec, *other));
          continue;
        }
        held = false;
        progress.clear();
        log_warning("{} breaks --max-error {:g}: {:.3g}/255 {}; hint: {}", name, budget, error,
                    job.options.budget.guarantee ? "at some pixel is not ruled out by its bounds"
                                                 : "rms with the most exact setting",
                    hint_for(job.options.budget, spec, error));
      }
    });
    if (!launch.of_rank_0(!again.empty())) break;
    draw_again(job, again, gallery, progress, launch);
  }
  return launch.of_rank_0(held);
}

}  // namespace ringsplat::app

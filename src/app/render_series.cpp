#include <fmt/format.h>

#include <utility>

#include "app/loading.hpp"
#include "app/render_job.hpp"
#include "app/series_loader.hpp"
#include "base/clock.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::app {
namespace {

/// The volumes of a series, each drawn while the next is read. The transfer function is the first one's, so
/// that colours mean the same in all pictures.
class SeriesRun {
 public:
  SeriesRun(Job& job, Progress& progress, Launch& launch)
      : job_(job),
        progress_(progress),
        launch_(launch),
        wiring_(launch.wiring(job.options.run.loopback)),
        loader_(job.series, std::move(job.volume), plan(), progress, launch) {}

  void run() {
    Scene scene = loader_.load(0);
    frame_ = choose_frame(job_, scene, wiring_, progress_, launch_);
    FrameOutput output(job_.options, job_.layout, scene.values.range, job_.memory, progress_);
    if (job_.annotation) {
      job_.annotation->keep_range(scene.values.range);
      output.annotate(*job_.annotation);
    }
    say_what_comes(scene.values.range);
    progress_.begin("rendering", double(loader_.size()));
    last_ended_ = now_seconds();
    try {
      for (std::size_t k = 0; k < loader_.size(); ++k) {
        if (k > 0) scene = loader_.load(k);
        loader_.read_ahead(k + 1);
        draw(k, std::exchange(scene, {}), output);
      }
    } catch (const InputError&) {
      progress_.end();
      if (launch_.rank() == 0) output.finish();
      throw;
    }
    progress_.end();
    if (launch_.rank() == 0) output.finish();
    launch_.take_leave();
    if (launch_.rank() == 0) output.make_film();
  }

 private:
  SeriesLoader::Plan plan() const {
    const Shown& shown = job_.options.frame.shown;
    const std::size_t pictures = FrameOutput::most_held(job_.options, job_.series.size());
    return {job_.load, job_.layout, wiring_,
            room_to_read_ahead(shown.width, shown.height, pictures, job_.memory, job_.layout, launch_)};
  }

  void say_what_comes(const ValueRange& range) {
    if (launch_.rank() != 0) return;
    progress_.print(fmt::format(
        "{} volumes, {} to {}; the transfer function {} of the first, {:g} to {:g}, is kept for all",
        loader_.size(), loader_.entry(0).name, loader_.entry(loader_.size() - 1).name,
        frame_.shown.transfer_function.name, range.low, range.high));
  }

  void draw(std::size_t k, Scene scene, FrameOutput& output) {
    FrameSpec frame = frame_;
    const auto& cameras = job_.plan.cameras;
    if (launch_.rank() == 0) frame.shown.camera = cameras[cameras.size() == 1 ? 0 : k];
    const SeriesEntry& entry = loader_.entry(k);
    output.show(entry.volume.path, scene.values.range);
    const auto take = [&](FrameResult&& result) {
      const double now = now_seconds();
      result.spec.frame = result.stats.frame = entry.number;
      result.stats.period = now - std::exchange(last_ended_, now);
      output.take(std::move(result), std::size_t(entry.number), 1);
    };
    render_all(std::move(scene), job_.layout, job_.options.run.protocol,
               launch_.rank() == 0 ? director_of({frame}, take) : Director{}, wiring_,
               job_.options.run.engine);
  }

  Job& job_;
  Progress& progress_;
  Launch& launch_;
  const Wiring wiring_;
  SeriesLoader loader_;
  FrameSpec frame_;
  double last_ended_ = 0;
};

}  // namespace

ExitCode render_series(Job& job, Progress& progress, Launch& launch) {
  SeriesRun(job, progress, launch).run();
  return ExitCode::done;
}

}  // namespace ringsplat::app

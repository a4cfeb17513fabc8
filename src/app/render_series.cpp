#include <fmt/format.h>

#include <utility>

#include "app/loading.hpp"
#include "app/render_job.hpp"
#include "app/series.hpp"
#include "base/clock.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::app {
namespace {

/// Draws one volume's view, and notes when it was done.
void draw(const Job& job, std::size_t k, Scene scene, FrameSpec frame, FrameOutput& output,
          double& last_ended, const Wiring& wiring, Launch& launch) {
  const auto& cameras = job.cameras;
  const bool first_rank = launch.rank() == 0;
  if (first_rank) frame.shown.camera = cameras[cameras.size() == 1 ? 0 : k];
  const SeriesEntry& entry = job.series[k];
  output.show(entry.volume.path, scene.values.range);
  const auto take = [&](FrameResult&& result) {
    const double now = now_seconds();
    result.spec.frame = result.stats.frame = entry.number;
    result.stats.period = now - std::exchange(last_ended, now);
    output.take(std::move(result), std::size_t(entry.number), 1);
  };
  const RunOptions& run = job.options.run;
  render_all(std::move(scene), job.layout, run.protocol, first_rank ? director_of({frame}, take) : Director{},
             wiring, run.engine);
}

}  // namespace

/// Each volume is drawn while the next is read. The transfer function is the first one's, so that colours
/// mean the same in all pictures.
ExitCode render_series(Job& job, Progress& progress, Launch& launch) {
  const Wiring wiring = launch.wiring(job.options.run.loopback);
  const Shown& shown = job.options.frame.shown;
  const std::size_t volumes = job.series.size(), pictures = FrameOutput::most_held(job.options, volumes);
  SeriesLoader loader(
      job.series, std::move(job.volume),
      {job.load, job.layout, wiring,
       room_to_read_ahead(shown.width, shown.height, pictures, job.memory, job.layout, launch)},
      progress, launch);
  Scene scene = loader.load(0);
  const FrameSpec frame = choose_frame(job, scene, wiring, progress, launch);
  const ValueRange range = scene.values.range;
  FrameOutput output(job.options, job.layout, range, job.memory, progress);
  if (job.annotation) {
    job.annotation->keep_range(range);
    output.annotate(*job.annotation);
  }
  const bool first_rank = launch.rank() == 0;
  if (first_rank)
    progress.print(fmt::format(
        "{} volumes, {} to {}; the transfer function {} of the first, {:g} to {:g}, is kept for all", volumes,
        job.series.front().name, job.series.back().name, frame.shown.transfer_function.name, range.low,
        range.high));
  progress.begin("rendering", double(volumes));
  double last_ended = now_seconds();
  try {
    for (std::size_t k = 0; k < volumes; ++k) {
      if (k > 0) scene = loader.load(k);
      loader.read_ahead(k + 1);
      draw(job, k, std::exchange(scene, {}), frame, output, last_ended, wiring, launch);
    }
  } catch (const InputError&) {
    progress.end();
    if (first_rank) output.finish();
    throw;
  }
  progress.end();
  if (first_rank) output.finish();
  launch.take_leave();
  if (first_rank) output.make_film();
  return ExitCode::done;
}

}  // namespace ringsplat::app

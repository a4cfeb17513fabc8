#include <utility>
#include <vector>

#include "app/commands.hpp"
#include "app/frame_output.hpp"
#include "app/render_job.hpp"
#include "base/clock.hpp"
#include "base/log.hpp"
#include "net/launcher.hpp"
#include "program/text_output.hpp"
#include "record/trace.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::app {
namespace {

void write_trace(Trace& trace, const std::string& file, const Layout& layout, Launch& launch) {
  trace.compare_clocks(launch.collectives());
  const Trace::Gathered all = trace.gather(launch.collectives());
  if (launch.rank() != 0) return;
  for (const auto& node : all.nodes)
    if (node.full)
      log_warning("{}: the record of {} is full and lacks its last frames", file, to_string(node.node));
  write_text_output(file, to_chrome_trace(all, layout));
}

/// Once all frames are drawn. All ranks call it.
void finish(FrameOutput& output, Launch& launch) {
  if (launch.rank() == 0) output.finish();
  launch.take_leave();
  if (launch.rank() == 0) output.make_film();
}

/// Says which volumes there are, and that transfer functions are those of the first, so that colours mean the
/// same in all pictures.
void say_series(const Job& job, const std::string& function, const ValueRange& range, Progress& progress) {
  const std::string kept = job.channels.empty()
                               ? fmt::format("transfer function {} of the first, {:g} to {:g}, is", function,
                                             range.low, range.high)
                               : "channels' windows of the first are";
  progress.print(fmt::format("{} volumes, {} to {}; the {} kept for all", job.series.size(),
                             job.series.front().name, job.series.back().name, kept));
}

}  // namespace

/// Each volume is drawn while the next is read.
ExitCode run(const RenderOptions& given, Launch& launch) {
  Job job = prepare(given, launch);
  const RenderOptions& o = job.options;
  // Results, which are lines for people, go to stderr when a file goes to stdout.
  const bool to_stdout = is_stdout(o.stats) || is_stdout(o.trace) || is_stdout(o.transfer_function_out);
  // Silent in a simulation: progress in simulated time tells nothing.
  Progress progress(launch.rank() != 0 || simulated(), to_stdout ? stderr : stdout);
  const std::size_t views = o.frames ? job.series.size() : job.cameras.size();
  SeriesLoader loader(job, pictures_at_once(job, views), progress, launch);
  Scene scene;
  loader.load_channels(scene, 0);
  const std::vector<FrameSpec> frames = choose_frames(job, scene, progress, launch);
  const ValueRange range = scene.values.range;
  if (job.annotation) job.annotation->keep_range(range);
  FrameOutput output(job, range, progress);
  const bool first_rank = launch.rank() == 0;
  if (first_rank && o.frames) say_series(job, frames[0].shown.transfer_function.name, range, progress);
  progress.begin("rendering", double(views));
  double last_ended = now_seconds();
  const auto take = [&](FrameResult&& result) {
    if (o.frames || !job.channels.empty() || in_several_frames(o)) {  // of several runs or frames
      const double now = now_seconds();
      result.stats.period = now - std::exchange(last_ended, now);
    }
    output.take(std::move(result));
  };
  Trace trace;
  ProtocolOptions protocol = o.run.protocol;
  if (!o.trace.empty()) protocol.trace = &trace;
  try {
    for (std::size_t volume = 0; volume < job.series.size(); ++volume) {
      if (volume > 0) loader.load_channels(scene, volume);
      const std::size_t part = volume * job.channels_drawn();
      loader.read_ahead(part + job.channels_drawn());
      output.show(job.part(part).path, scene.values.range);
      render_all(job, protocol, std::exchange(scene, {}), director_of(job, volume, frames, take), launch);
    }
  } catch (const InputError&) {
    progress.end();
    if (first_rank) output.finish();
    throw;
  }
  progress.end();
  const auto judge = [&] { return output.judge(launch); };
  const auto replace = [&](FrameResult&& result) { output.replace(std::move(result)); };
  const bool held = !o.budget.max_error || hold_budget(job, {judge, replace}, progress, launch);
  if (o.error.truth) judge();
  finish(output, launch);
  if (!o.trace.empty()) write_trace(trace, o.trace, job.layout, launch);
  return held ? ExitCode::done : ExitCode::comparison_failed;
}

}  // namespace ringsplat::app

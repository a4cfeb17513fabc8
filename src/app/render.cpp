#include <fmt/format.h>
#include <unistd.h>

#include <memory>
#include <utility>

#include "app/browsing.hpp"
#include "app/commands.hpp"
#include "app/frame_output.hpp"
#include "app/loading.hpp"
#include "app/render_job.hpp"
#include "app/series.hpp"
#include "base/clock.hpp"
#include "base/log.hpp"
#include "net/launcher.hpp"
#include "program/text_output.hpp"
#include "record/trace.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::app {
namespace {

/// The stream of `--path -`. What is passed by reference must outlive it.
std::unique_ptr<ViewStream> views_on_stdin(const RenderOptions& o, const FrameSpec& frame, const Grid& grid,
                                           Progress& progress) {
  const auto check = [&](const Camera& camera) {
    FrameSpec spec = frame;
    spec.shown.camera = camera;
    check_view(o, std::move(spec), grid);
  };
  const auto warn = [&progress](const std::string& text) {
    progress.clear();
    log_warning("{}", text);
  };
  return std::make_unique<ViewStream>(STDIN_FILENO, "--path -", o.frame.shown.camera,
                                      ViewStream::Hooks{check, warn});
}

void write_trace(Trace& trace, const std::string& file, const Layout& layout, Launch& launch) {
  trace.compare_clocks(launch.collectives());
  const Trace::Gathered all = trace.gather(launch.collectives());
  if (launch.rank() != 0) return;
  for (const auto& node : all.nodes)
    if (node.full)
      log_warning("{}: the record of {} is full and lacks its last frames", file, to_string(node.node));
  write_text_output(file, to_chrome_trace(all, layout));
}

/// True when a file is written to stdout; results, which are lines for people, then go to stderr.
bool writes_to_stdout(const RenderOptions& o) {
  return is_stdout(o.stats) || is_stdout(o.trace) || is_stdout(o.transfer_function_out);
}

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

/// Each volume is drawn while the next is read. The transfer function is the first one's, so that colours
/// mean the same in all pictures.
ExitCode render_series(Job& job, Progress& progress, Launch& launch) {
  const Wiring wiring = launch.wiring(job.options.run.loopback);
  const std::size_t volumes = job.series.size();
  SeriesLoader loader(job, wiring, FrameOutput::most_held(job.options, volumes), progress, launch);
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

}  // namespace

ExitCode run_render(const RenderOptions& given, Launch& launch) {
  Job job = prepare(given, launch);
  const RenderOptions& o = job.options;
  // Silent in a simulation: progress in simulated time tells nothing.
  Progress progress(launch.rank() != 0 || simulated(), writes_to_stdout(o) ? stderr : stdout);
  if (o.frames) return render_series(job, progress, launch);
  const Wiring wiring = launch.wiring(o.run.loopback);
  Scene scene = load(job.volume, job.load, job.layout, wiring, progress);
  const FrameSpec frame = choose_frame(job, scene, wiring, progress, launch);
  const ValueRange range = scene.values.range;
  FrameOutput output(o, job.layout, range, job.memory, progress);
  if (job.annotation) output.annotate(*job.annotation);
  const bool reads_stdin = o.path == "-";
  Browsing browsing(
      frame, job.cameras,
      reads_stdin && launch.rank() == 0 ? views_on_stdin(o, frame, job.volume.grid, progress) : nullptr,
      o.progressive);
  progress.begin("rendering", double(job.cameras.size()));
  Trace trace;
  ProtocolOptions protocol = o.run.protocol;
  if (!o.trace.empty()) protocol.trace = &trace;
  render_all(std::move(scene), job.layout, protocol,
             launch.rank() == 0 ? browsing.director(output, progress) : Director{}, wiring, o.run.engine);
  progress.end();
  const auto judge = [&] { return output.judge(); };
  const auto replace = [&](FrameResult&& result) { output.replace(std::move(result)); };
  const bool held = !o.budget.max_error || hold_budget(job, {judge, replace}, wiring, progress, launch);
  if (launch.rank() == 0) output.finish();
  launch.take_leave();
  if (launch.rank() == 0) output.make_film();
  if (!o.trace.empty()) write_trace(trace, o.trace, job.layout, launch);
  if (const std::string summary = browsing.summary(); !summary.empty()) progress.print(summary);
  if (reads_stdin) launch.check_on_rank_0([&] { browsing.check_stream(); });
  return held ? ExitCode::done : ExitCode::comparison_failed;
}

}  // namespace ringsplat::app

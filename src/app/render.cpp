#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <utility>
#include <vector>

#include "app/commands.hpp"
#include "app/frame_output.hpp"
#include "app/loading.hpp"
#include "app/render_job.hpp"
#include "app/series.hpp"
#include "app/views.hpp"
#include "base/clock.hpp"
#include "base/log.hpp"
#include "net/launcher.hpp"
#include "program/text_output.hpp"
#include "record/trace.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::app {
namespace {

/// The views that are rendered, in their order: `views` first, then those of `stream`; null: no others.
class Browsing {
 public:
  /// `frame` holds what all frames have in common.
  Browsing(const FrameSpec& frame, std::vector<Camera> views, std::shared_ptr<ViewStream> stream)
      : frame_(frame), views_(std::move(views)), stream_(std::move(stream)) {}

  /// The director of the run. `output` takes finished frames; both arguments must outlive the run.
  Director director(FrameOutput& output, Progress& progress) {
    Director director{[this, &progress] {
                        auto frame = next();
                        say_whether_waiting(frame.has_value(), progress);
                        return frame;
                      },
                      [this, &output](FrameResult&& result) {
                        --under_way_;
                        const auto view = std::size_t(result.spec.frame);
                        output.take(std::move(result), view);
                      }};
    if (stream_) director.may_come = [this] { return stream_->may_come(); };
    return director;
  }

  /// Throws InputError when some of the stream's lines were no views. Call it when all frames are done.
  void check_stream() {
    if (stream_) stream_->check_all_was_read();
  }

 private:
  std::optional<FrameSpec> next() {
    const auto view = next_view();
    if (!view) return std::nullopt;
    ++under_way_;
    FrameSpec spec = frame_;
    spec.shown.camera = *view;
    return spec;
  }

  void say_whether_waiting(bool frame_comes, Progress& progress) {
    const bool waiting = !frame_comes && under_way_ == 0 && stream_ && stream_->may_come();
    if (waiting == waiting_) return;
    waiting_ = waiting;
    if (waiting)
      progress.wait_for("waiting for views on stdin");
    else
      progress.go_on();
  }

  std::optional<Camera> next_view() {
    if (next_listed_ < views_.size()) return views_[next_listed_++];
    return stream_ ? stream_->next() : std::nullopt;
  }

  FrameSpec frame_;
  std::vector<Camera> views_;
  std::shared_ptr<ViewStream> stream_;
  std::size_t next_listed_ = 0;  ///< into views_
  int under_way_ = 0;            ///< frames
  bool waiting_ = false;         ///< for a view, while no frame is being rendered
};

/// The stream of `--path -`. What is passed by reference must outlive it.
std::shared_ptr<ViewStream> views_on_stdin(const RenderOptions& o, const FrameSpec& frame, const Grid& grid,
                                           Progress& progress) {
  const auto check = [&](const Camera& camera) {
    FrameSpec spec = frame;
    spec.shown.camera = camera;
    check_frame(spec, grid);
  };
  const auto warn = [&progress](const std::string& text) {
    progress.clear();
    log_warning("{}", text);
  };
  std::ios::sync_with_stdio(false);  // else std::cin takes an error for the end
  return ViewStream::of(std::cin, "--path -", o.frame.shown.camera, {check, warn});
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

/// Draws one volume of the series: with --frames one view of it, else all.
void draw(const Job& job, std::size_t k, Scene scene, const FrameSpec& frame, FrameSum& sum,
          const Wiring& wiring, Launch& launch) {
  const std::size_t channel = k % job.channels_drawn(), volume = k / job.channels_drawn();
  std::vector<Camera> cameras = job.cameras;
  if (job.options.frames && cameras.size() > 1) cameras = {cameras[volume]};
  const auto take = [&](FrameResult&& result) {
    const auto view = job.options.frames ? job.series[k].number : result.spec.frame;
    sum.add(std::move(result), std::size_t(view), channel + 1 == job.channels_drawn());
  };
  const RunOptions& run = job.options.run;
  render_all(std::move(scene), job.layout, run.protocol,
             launch.rank() == 0 ? director_of(frames_of(frame, cameras), take) : Director{}, wiring,
             run.engine);
}

/// Each volume, or channel, is drawn while the next is read. Transfer functions are those of the first
/// volume, so that colours mean the same in all pictures.
ExitCode render_series(Job& job, Progress& progress, Launch& launch) {
  const Wiring wiring = launch.wiring(job.options.run.loopback);
  const std::size_t volumes = job.volumes(), views = job.options.frames ? volumes : job.cameras.size();
  SeriesLoader loader(job, wiring, pictures_at_once(job, views), progress, launch);
  Scene scene = loader.load(0);
  std::vector<FrameSpec> frames{choose_frame(job, scene, wiring, progress, launch)};
  const ValueRange range = scene.values.range;
  FrameOutput output(job.options, job.layout, range, job.memory, job.channels, progress);
  if (job.annotation) {
    job.annotation->keep_range(range);
    output.annotate(*job.annotation);
  }
  const bool first_rank = launch.rank() == 0;
  if (first_rank && job.options.frames)
    progress.print(fmt::format(
        "{} volumes, {} to {}; the transfer function {} of the first, {:g} to {:g}, is kept for all", volumes,
        job.series.front().full_name(), job.series.back().full_name(), frames[0].shown.transfer_function.name,
        range.low, range.high));
  progress.begin("rendering", double(views));
  double last_ended = now_seconds();
  FrameSum sum([&](FrameResult&& result, std::size_t view) {
    const double now = now_seconds();
    result.spec.frame = result.stats.frame = std::int64_t(view);
    result.stats.period = now - std::exchange(last_ended, now);
    output.take(std::move(result), view);
  });
  try {
    for (std::size_t k = 0; k < job.series.size(); ++k) {
      const std::size_t channel = k % job.channels_drawn();
      if (k > 0) scene = loader.load(k);
      if (k > 0 && k < job.channels_drawn())
        frames.push_back(choose_frame(job, scene, wiring, progress, launch, channel));
      loader.read_ahead(k + 1);
      if (channel == 0) output.show(job.series[k].volume.path, scene.values.range);
      draw(job, k, std::exchange(scene, {}), frames[channel], sum, wiring, launch);
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
  if (o.frames || !job.channels.empty()) return render_series(job, progress, launch);
  const Wiring wiring = launch.wiring(o.run.loopback);
  Scene scene = load(job.volume, job.load, job.layout, wiring, progress);
  const FrameSpec frame = choose_frame(job, scene, wiring, progress, launch);
  const ValueRange range = scene.values.range;
  FrameOutput output(o, job.layout, range, job.memory, job.channels, progress);
  if (job.annotation) output.annotate(*job.annotation);
  const bool reads_stdin = o.path == "-";
  Browsing browsing(
      frame, job.cameras,
      reads_stdin && launch.rank() == 0 ? views_on_stdin(o, frame, job.volume.grid, progress) : nullptr);
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
  if (reads_stdin) launch.check_on_rank_0([&] { browsing.check_stream(); });
  return held ? ExitCode::done : ExitCode::comparison_failed;
}

}  // namespace ringsplat::app

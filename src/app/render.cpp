#include <fmt/format.h>
#include <unistd.h>

#include <map>
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
#include "truth/sampling.hpp"

namespace ringsplat::app {
namespace {

/// Which frames are rendered, in which order: each view once, or with --progressive from coarse to fine
/// (Neumann 1992, section 4.4). A refinement is dropped when a newer view has come; a view's first, coarse
/// picture never is.
class Browsing {
 public:
  /// `views` come first, then those of `stream`; null: no others. `frame` holds what all frames have in
  /// common.
  Browsing(const FrameSpec& frame, std::vector<Camera> views, std::unique_ptr<ViewStream> stream,
           bool progressive)
      : frame_(frame),
        levels_(levels_of(frame, progressive)),
        views_(std::move(views)),
        stream_(std::move(stream)),
        next_level_(levels_.size()) {}

  /// The director of the run. `output` takes finished frames; both arguments must outlive the run.
  Director director(FrameOutput& output, Progress& progress) {
    Director director{
        [this, &progress] {
          auto frame = next();
          say_whether_waiting(frame.has_value(), progress);
          return frame;
        },
        [this, &output, &progress](FrameResult&& result) { take(std::move(result), output, progress); }};
    if (stream_) {
      director.may_come = [this] { return stream_->may_come(); };
      director.unwanted = [this](const FrameSpec& spec) { return unwanted(spec); };
    }
    return director;
  }

  /// Views shown and refinements dropped, for a line at the end; empty when nothing was dropped.
  std::string summary() const {
    if (dropped_ == 0) return {};
    return fmt::format("{} views, {} refinements dropped for newer ones", shown_views_, dropped_);
  }

  /// Throws InputError when some of the stream's lines were no views. Call it when all frames are done.
  void check_stream() {
    if (stream_) stream_->check_all_was_read();
  }

 private:
  struct Step {
    std::size_t view;   ///< from 0
    std::size_t level;  ///< into levels_
  };
  struct Shown {
    Reduction reduction;
    Image image;
    std::int64_t frame;
    double seconds;  ///< since the view was first announced
  };

  std::optional<FrameSpec> next() {
    const bool refine = next_level_ < levels_.size() && !(next_level_ > 0 && newer_view_waits());
    if (!refine) {
      dropped_ += levels_.size() - next_level_;
      next_level_ = levels_.size();
      const auto view = next_view();
      if (!view) return std::nullopt;
      current_ = view;
      next_level_ = 0;
      asked_[shown_views_++] = now_seconds();
    }
    FrameSpec spec = frame_;
    spec.shown.camera = *current_;
    spec.shown.reduction = levels_[next_level_];
    steps_[next_frame_++] = {shown_views_ - 1, next_level_++};
    return spec;
  }

  void say_whether_waiting(bool frame_comes, Progress& progress) {
    const bool waiting = !frame_comes && steps_.empty() && stream_ && stream_->may_come();
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

  bool newer_view_waits() { return stream_ && stream_->has_next(); }

  bool unwanted(const FrameSpec& spec) {
    const auto step = steps_.find(spec.frame);
    if (step == steps_.end() || step->second.level == 0) return false;
    if (step->second.view + 1 == shown_views_ && !newer_view_waits()) return false;
    ++dropped_;
    steps_.erase(step);
    return true;
  }

  void take(FrameResult&& result, FrameOutput& output, Progress& progress) {
    const auto found = steps_.find(result.spec.frame);
    if (found == steps_.end()) return;  // unwanted() dropped it, but it was already complete
    const Step step = found->second;
    steps_.erase(found);
    const double seconds = now_seconds() - asked_.at(step.view);
    const bool full = step.level + 1 == levels_.size();
    if (levels_.size() > 1) {
      if (full)
        compare_with_full(step, result.image, seconds, output, progress);
      else
        coarse_[step.view].push_back({result.spec.shown.reduction, result.image, result.spec.frame, seconds});
    }
    output.take(std::move(result), step.view, full ? 1 : levels_[step.level].factor);
    if (!full) return;
    // Earlier views that are not yet fully refined never will be.
    coarse_.erase(coarse_.begin(), coarse_.upper_bound(step.view));
    asked_.erase(asked_.begin(), asked_.upper_bound(step.view));
  }

  void compare_with_full(const Step& step, const Image& full, double seconds, FrameOutput& output,
                         Progress& progress) {
    std::string line = fmt::format("view {}:", step.view);
    for (const Shown& shown : coarse_[step.view]) {
      const truth::ErrorFigures error = truth::compare(shown.image, full).total;
      line += fmt::format(" 1/{} after {:.4f} s, {:.3g}/255 rms;", shown.reduction.factor, shown.seconds,
                          error.rmse);
      output.add_refinement(shown.frame, {shown.seconds, error.rmse, error.largest});
    }
    progress.print(line + fmt::format(" full after {:.4f} s", seconds));
  }

  FrameSpec frame_;
  std::vector<Reduction> levels_;
  std::vector<Camera> views_;
  std::unique_ptr<ViewStream> stream_;
  std::size_t next_listed_ = 0;  ///< into views_
  std::size_t shown_views_ = 0;
  std::optional<Camera> current_;
  std::size_t next_level_ = 0;
  std::int64_t next_frame_ = 0;
  std::map<std::int64_t, Step> steps_;                ///< by frame, announced and not done
  std::map<std::size_t, double> asked_;               ///< when a view was first announced
  std::map<std::size_t, std::vector<Shown>> coarse_;  ///< a view's pictures so far
  std::size_t dropped_ = 0;
  bool waiting_ = false;  ///< for a view, while no frame is being rendered
};

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
    output.take(std::move(result), view, 1);
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

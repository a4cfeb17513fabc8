#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "app/auto_roles.hpp"
#include "app/browsing.hpp"
#include "app/commands.hpp"
#include "app/error_budget.hpp"
#include "app/first_view.hpp"
#include "app/frame_output.hpp"
#include "app/keep_budget.hpp"
#include "app/loading.hpp"
#include "app/output_names.hpp"
#include "app/series_loader.hpp"
#include "app/simulation_options.hpp"
#include "app/steepness.hpp"
#include "app/text_output.hpp"
#include "app/threads.hpp"
#include "app/transfer_function_option.hpp"
#include "app/views.hpp"
#include "base/clock.hpp"
#include "base/log.hpp"
#include "base/output_file.hpp"
#include "frame/frame_geometry.hpp"
#include "images/image_io.hpp"
#include "model/charge.hpp"
#include "net/blocks.hpp"
#include "record/trace_json.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::app {
namespace {

/// What only rank 0 knows, as only it reads the small files and writes the results.
struct Plan {
  std::optional<TransferFunctionChoice> transfer_function;
  std::vector<Camera> cameras;
};

Plan make_plan(const RenderOptions& o) {
  Plan plan;
  plan.transfer_function.emplace(o.transfer_function);
  if (!o.output.empty()) {
    check_image_name(o.output, "-o", !o.background);
    check_can_write(o.output, "-o");
  }
  if (!o.stats.empty()) check_can_write_text(o.stats, "--stats");
  if (!o.trace.empty()) check_can_write_text(o.trace, "--trace");
  if (!o.transfer_function_out.empty()) check_can_write_text(o.transfer_function_out, "--tf-out");
  refuse_clashes(
      {{"-o", o.output}, {"--stats", o.stats}, {"--trace", o.trace}, {"--tf-out", o.transfer_function_out}},
      {{"the volume", o.volume.path}, {"--path", o.path}, {"--tf", o.transfer_function}});
  return plan;
}

/// Throws InputError when the frame's view cannot be rendered at some level.
void check_view(const RenderOptions& o, FrameSpec spec, const Grid& grid) {
  for (const Reduction& level : Browsing::levels(spec, o.progressive)) {
    spec.shown.reduction = level;
    static_cast<void>(make_geometry(spec, grid));
  }
}

/// Finds everything wrong with a frame before a voxel is read.
void check_frames(const RenderOptions& o, const Plan& plan, const Grid& grid) {
  FrameSpec spec = o.frame;
  spec.shown.transfer_function = stand_in_function();
  check(spec);
  for (std::size_t k = 0; k < plan.cameras.size(); ++k) {
    spec.shown.camera = plan.cameras[k];
    try {
      check_view(o, spec, grid);
    } catch (const InputError& e) {
      if (plan.cameras.size() == 1) throw;
      throw InputError(fmt::format("frame {}: {}", k, e.what()));
    }
  }
}

/// One camera is for all volumes of a series.
void check_one_camera_each(const Plan& plan, const RenderOptions& o, std::size_t volumes) {
  if (plan.cameras.size() == volumes || (o.orbit == 0 && o.path.empty())) return;
  throw InputError(
      fmt::format("{} has {} views, but --frames {} chooses {} volumes", o.orbit > 0 ? "--orbit" : "--path",
                  plan.cameras.size(), o.frames->text, volumes),
      o.orbit > 0 ? fmt::format("the camera moves on with each volume: give --orbit {}", volumes)
                  : "each line is the view of one volume");
}

/// The pictures of a series of pages may have their names.
void refuse_replacing_volumes(const RenderOptions& o, const std::vector<SeriesEntry>& series) {
  std::error_code error;
  std::set<std::filesystem::path> volumes;
  for (const SeriesEntry& entry : series)
    volumes.insert(std::filesystem::weakly_canonical(entry.volume.path, error));
  for (const SeriesEntry& entry : series) {
    const auto picture = output_file(o, std::size_t(entry.number));
    if (volumes.contains(std::filesystem::weakly_canonical(picture, error)))
      throw InputError(fmt::format("-o {} would replace {}, which is read", o.output, picture.string()),
                       "write into another folder, or under another name");
  }
}

std::array<bool, 3> agree_on_axes(const RenderOptions& o, const Plan& plan, const Grid& grid,
                                  Launch& launch) {
  if (o.keep_all_axes || o.path == "-") return {true, true, true};
  std::array<bool, 3> axes{};
  if (launch.rank() == 0)
    axes = needed_axes(plan.cameras, grid, o.frame.shown.width, o.frame.shown.height, o.frame.shown.clip);
  const Block block = launch.collectives().broadcast(block_of_value(axes), 0);
  return value_of<std::array<bool, 3>>(block, "the axes to keep");
}

}  // namespace

LoadOptions load_options(const RenderOptions& o, std::array<bool, 3> axes) {
  LoadOptions load{axes,
                   needs_normals(o.frame),
                   {},
                   o.frame.shown.reduction.prefilter,
                   needs_cell_ranges(o.frame),
                   o.frame.shown.clip};
  if (o.budget.other_engine) {
    FrameSpec other = o.frame;
    other.how = *o.budget.other_engine;
    load.with_normals |= needs_normals(other);
    load.with_cell_ranges |= needs_cell_ranges(other);
  }
  for (const Reduction& level : Browsing::levels(o.frame, o.progressive))
    load.factors.push_back(level.factor);
  if (o.budget.max_error && !o.budget.fixed_undersample) load.factors = levels_to_choose_from();
  return load;
}

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

/// Rank 0's transfer function for the loaded volume, written out when asked.
TransferFunction make_transfer_function(const RenderOptions& o, const Plan& plan, const Scene& scene) {
  TransferFunction tf = plan.transfer_function->make(scene.histogram);
  check(tf, o.transfer_function);
  if (!o.transfer_function_out.empty()) write_text_output(o.transfer_function_out, to_paraview_json(tf));
  return tf;
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

/// A run, all decided and checked before a voxel is read.
struct Job {
  RenderOptions options;
  Layout layout;
  Plan plan;
  std::vector<SeriesEntry> series;       ///< one volume, without --frames
  OpenedVolume volume;                   ///< the first of them
  std::string view_note;                 ///< on rank 0: what is said of the view, or nothing
  std::optional<Annotation> annotation;  ///< on rank 0
  LoadOptions load;
  SliceMemory memory;
};

Job prepare(const RenderOptions& given, Launch& launch) {
  Job job;
  RenderOptions& o = job.options = given;
  prepare_simulation(o.run, launch);
  job.layout = choose_layout(o.run, launch.over_mpi(), launch.ranks());
  check(o.run.protocol);
  check(o.run.engine);
  warn_of_shared_cores(o.run.engine.threads_per_rank, launch);
  launch.check_on_rank_0([&] { job.plan = make_plan(o); });
  if (o.frames && simulated())
    throw InputError("--frames: the next volume is read by the clock on the wall, not the simulated one",
                     "simulate one volume at a time");
  job.series = find_series(o.volume, o.frames, launch);
  o.volume = job.series.front().volume;
  if (o.frames && !o.output.empty()) launch.check_on_rank_0([&] { refuse_replacing_volumes(o, job.series); });
  job.volume = open(o.volume, launch);
  const Grid& grid = job.volume.grid;
  launch.check_on_all_ranks([&] { o.frame.shown.clip = clip_box(o.clip, grid); });
  launch.check_on_rank_0([&] {
    job.view_note = complete_view(o, grid, job.volume.notes);
    job.plan.cameras = views_of(o);
    if (o.frames) check_one_camera_each(job.plan, o, job.series.size());
    check_frames(o, job.plan, grid);
    if (o.annotate) job.annotation.emplace(grid, job.volume.notes, o.background);
  });
  job.load = load_options(o, agree_on_axes(o, job.plan, grid, launch));
  if (o.run.choose_roles) job.layout = choose_roles(o, job.plan.cameras, grid, job.load, launch);
  o.frame.division.dealt_to = drawing_renderers(job.layout, launch);
  job.memory = predict_memory(grid, job.load, job.layout.gps);
  launch.check_on_all_ranks([&] {
    check_memory(o.frame.shown.width, o.frame.shown.height,
                 FrameOutput::most_held(o, job.plan.cameras.size()), job.memory, job.layout, launch);
  });
  if (!job.view_note.empty()) log_info("{}", job.view_note);
  log_roles(job.layout, job.memory, launch);
  return job;
}

/// Loads the scene again, from the same volume.
Scene reload(Job& job, const Wiring& wiring, Progress& progress, Launch& launch) {
  const Facts before = std::exchange(job.volume, open(job.options.volume, launch)).facts;
  launch.check_on_rank_0([&] {
    if (job.volume.facts != before)
      throw InputError(fmt::format("{} has changed since it was first read", job.options.volume.path),
                       "start again when nobody writes to it any more");
  });
  return load(job.volume, job.load, job.layout, wiring, progress);
}

/// The part that all frames share, with the transfer function and, under --max-error, the shortcuts chosen
/// for the loaded scene.
FrameSpec choose_frame(Job& job, Scene& scene, const Wiring& wiring, Progress& progress, Launch& launch) {
  const RenderOptions& o = job.options;
  FrameSpec frame = o.frame;
  launch.check_on_rank_0([&] { frame.shown.transfer_function = make_transfer_function(o, job.plan, scene); });
  if (o.budget.max_error &&
      keep_budget(o, job.plan.cameras, job.load.kept_axes, job.layout, scene, frame, progress, launch))
    scene = reload(job, wiring, progress, launch);
  return frame;
}

/// Says on rank 0 what splats err, unless their error is measured.
void warn_of_steepness(const RenderOptions& o, const FrameSpec& frame, const ValueRange& range,
                       Progress& progress, const Launch& launch) {
  const bool drawn = !o.run.engine.simulation.count_only;
  if (launch.rank() != 0 || o.error.truth || !drawn || !std::holds_alternative<Splats>(frame.how)) return;
  if (const std::string why = why_splats_err(frame.shown.transfer_function, range); !why.empty()) {
    progress.clear();
    log_warning("{}", why);
  }
}

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
    warn_of_steepness(job_.options, frame_, scene.range, progress_, launch_);
    FrameOutput output(job_.options, job_.layout, scene.range, job_.memory, progress_);
    if (job_.annotation) output.annotate(*job_.annotation);
    say_what_comes(scene.range);
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
    output.show(entry.volume.path, scene.range);
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

ExitCode render_series(Job& job, Progress& progress, Launch& launch) {
  SeriesRun(job, progress, launch).run();
  launch.take_leave(job.options.run.protocol.stall_timeout);
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

  const ValueRange range = scene.range;
  warn_of_steepness(o, frame, range, progress, launch);
  FrameOutput output(o, job.layout, range, job.memory, progress);
  if (job.annotation) output.annotate(*job.annotation);
  const bool reads_stdin = o.path == "-";
  Browsing browsing(
      frame, job.plan.cameras,
      reads_stdin && launch.rank() == 0 ? views_on_stdin(o, frame, job.volume.grid, progress) : nullptr,
      o.progressive);
  progress.begin("rendering", double(job.plan.cameras.size()));
  Trace trace;
  ProtocolOptions protocol = o.run.protocol;
  if (!o.trace.empty()) protocol.trace = &trace;
  render_all(std::move(scene), job.layout, protocol,
             launch.rank() == 0 ? browsing.director(output, progress) : Director{}, wiring, o.run.engine);
  progress.end();
  if (launch.rank() == 0) output.finish();
  launch.take_leave(protocol.stall_timeout);
  if (!o.trace.empty()) write_trace(trace, o.trace, job.layout, launch);
  if (const std::string summary = browsing.summary(); !summary.empty()) progress.print(summary);
  if (reads_stdin) launch.check_on_rank_0([&] { browsing.check_stream(); });
  return ExitCode::done;
}

}  // namespace ringsplat::app

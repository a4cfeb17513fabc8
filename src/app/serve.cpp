#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <tuple>
#include <utility>

#include "app/commands.hpp"
#include "app/render_job.hpp"
#include "app/viewer_options.hpp"
#include "base/child_program.hpp"
#include "base/log.hpp"
#include "base/output_file.hpp"
#include "net/launcher.hpp"
#include "options/option_tables.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/private_folder.hpp"
#include "volume/clipped.hpp"

namespace ringsplat::app {
namespace {

constexpr std::size_t pictures_held = 4;  // in flight, a sum of channels, being encoded, a snapshot

Job prepare(const ServeOptions& options, Launch& launch) {
  Job job;
  RenderOptions& o = job.options = options.picture;
  if (o.run.simulation.machine || simulated())
    throw InputError("nobody can look at simulated ranks", "use ringsplat render");
  settle_ranks(job, launch);
  o.run.engine.encodes_pictures = true;
  launch.check_on_rank_0([&] { job.transfer_function.emplace(o.transfer_function, o.colour); });
  find_volumes(job, launch);
  constexpr std::size_t most = 10000;  // the page gets the names of all
  if (job.series.size() > most)
    throw InputError(fmt::format("the series has {} volumes, the viewer shows {}", job.series.size(), most),
                     "choose fewer by --frames A:B:STEP");
  const Grid& grid = job.volume.grid;
  o.frame.shown.reduction.prefilter = true;
  std::string view_note;
  launch.check_on_rank_0([&] {
    view_note = complete_view(o, grid, job.volume.notes);
    FrameSpec first = o.frame;
    first.shown.transfer_function = stand_in_function();
    for (const auto& level : serve::make_levels(grid.dims)) check_frame(serve::at_level(first, level), grid);
  });
  job.load = serve::needed_for_levels(o.frame, grid);
  settle_layout(job, pictures_held, job.channels_drawn(), launch);
  if (!view_note.empty()) log_info("{}", view_note);
  return job;
}

/// Every user of the machine can read what a program was started with, so xdg-open gets the name of a file
/// that only its owner can reach, and that leads on to the address with its token. Its folder lasts until
/// another part is shown, or the job ends.
std::unique_ptr<serve::PrivateFolder> open_in_browser(const std::string& url) {
  try {
    // The user's own folder of what lasts no longer than a login, in memory.
    const char* const own = std::getenv("XDG_RUNTIME_DIR");
    const bool usable = own != nullptr && access(own, W_OK | X_OK) == 0;
    auto folder = std::make_unique<serve::PrivateFolder>("page", usable ? own : "");
    const std::filesystem::path file = folder->path() / "page.html";
    write_text(
        file,
        fmt::format("<!doctype html><meta charset=\"utf-8\"><title>Ringsplat</title>"
                    "<meta http-equiv=\"refresh\" content=\"0; url={0}\"><a href=\"{0}\">Ringsplat</a>\n",
                    url));
    std::error_code ignored;
    std::filesystem::permissions(file, std::filesystem::perms{0600}, ignored);
    const auto program = find_program("xdg-open");
    if (!program) throw RunError("there is no xdg-open");
    start_program(*program, {file.string()}, "/");
    return folder;
  } catch (const RunError& e) {
    log_warning("--open: {}; open the line above in a browser", e.what());
    return nullptr;
  }
}

/// Shows on the pages what the job warns of, also before there are any.
class Warnings {
 public:
  Warnings() {
    set_log_sink([this](LogLevel level, const std::string& text) {
      log_to_stderr(level, text);
      if (level < LogLevel::warning) return;
      const std::lock_guard lock(mutex_);
      if (viewer_ != nullptr)
        viewer_->warn(text);
      else
        early_.push_back(text);
    });
  }
  ~Warnings() { set_log_sink({}); }

  /// Null: on none, until there is one again.
  void show_on(serve::Viewer* viewer) {
    const std::lock_guard lock(mutex_);
    viewer_ = viewer;
    if (viewer_ == nullptr) return;
    for (const std::string& text : std::exchange(early_, {})) viewer_->warn(text);
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> early_;
  serve::Viewer* viewer_ = nullptr;
};

extern "C" void end_soon(int) { alarm(2); }

/// Launchers that end a job signal all of its ranks. Rank 0 then ends it in order; the others wait for that,
/// but not for long.
void leave_the_end_to_rank_0() {
  struct sigaction action {};
  action.sa_handler = end_soon;
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGINT, &action, nullptr);
}

/// Loads the volumes `next` in all channels, without the first where the scene is that already. Where one
/// cannot be loaded, tells pages why and loads `held` again, or of these the one that can be. Returns those
/// that are loaded.
std::vector<int> load_next(const std::vector<int>& next, const std::vector<int>& held, SeriesLoader& loader,
                           Scene& scene, const Job& job, serve::Viewer* viewer, Launch& launch) {
  int failed = next.back();
  try {
    const std::size_t count = next.size();
    launch.check_on_all_ranks([&] { check_memory(job, count * pictures_held, launch, double(count)); });
    for (std::size_t k = scene.grid.voxels() > 0 ? 1 : 0; k < count; ++k) {
      failed = next[k];
      loader.load_channels(scene, std::size_t(failed));
    }
  } catch (const InputError& e) {
    if (next == held && held.size() == 1) throw;
    if (viewer != nullptr) viewer->not_loaded(failed, e.what());
    scene = {};
    if (next != held) return load_next(held, held, loader, scene, job, viewer, launch);
    const std::vector<int> other{failed == held.front() ? held.back() : held.front()};
    return load_next(other, other, loader, scene, job, viewer, launch);
  }
  if (viewer != nullptr) viewer->loaded({next, ranges_of(scene)});
  return next;
}

/// How coarse data is made that is shown while the first volume is loaded: of one that takes its time, where
/// slices can be left out, or a pyramid has the level, and there is memory for an eighth more.
std::optional<Reduction> coarse_first(const ServeOptions& options, const Job& job, Launch& launch) {
  const OpenedVolume& volume = job.volume;
  const double bytes = double(volume.grid.bytes()) * double(job.channels_drawn());
  if (!volume.concurrent || volume.has_labels || job.load.factors.size() == 1 ||
      !options.picture.more_volumes.empty() || bytes < options.coarse_above_mib * (1 << 20))
    return {};
  try {
    launch.check_on_all_ranks([&] { check_memory(job, pictures_held, launch, 1.125); });
    if (volume.layer_depth == 1) return Reduction{2};
    VolumeOptions coarser = job.options.volume;
    coarser.choice.coarser = true;
    const Facts half = facts_of(open(coarser, launch).grid);
    for (const Reduction& halving : {Reduction{2, true}, Reduction{2}})
      if (facts_of(reduced_grid(volume.grid, halving)) == half) return halving;
  } catch (const InputError&) {
    // The volume can be loaded as a whole.
  }
  return {};
}

/// The first volume and how it is shown; of coarse data where `coarse` says how to make it and that will do.
std::tuple<Scene, MadeFunction, Shown> load_first(const std::optional<Reduction>& coarse,
                                                  SeriesLoader& loader, Job& job, Launch& launch) {
  Scene scene;
  MadeFunction made;
  Shown shown;
  const auto load = [&](const std::optional<Reduction>& half) {
    scene = {};
    shown = job.options.frame.shown;
    job.load.half_of = half ? std::optional(job.volume.grid) : std::nullopt;
    job.load.prefilter = half.value_or(shown.reduction).prefilter;
    loader.load_channels(scene, 0);
    launch.check_on_rank_0([&] {
      made = job.channels.empty() ? job.transfer_function->make(scene.values, shown)
                                  : make_function(job.channels.front(), job.options, scene.values, shown);
    });
  };
  try {
    load(coarse);
  } catch (const InputError&) {
    // What is wrong with an eighth of the voxels may be right with all.
    if (!coarse) throw;
    load({});
  }
  if (job.channels.empty() && launch.of_rank_0(shown.interpolation == Interpolation::nearest) &&
      job.load.factors.size() > 1) {
    // A mean of labels is another label, and coarse data may lack some.
    job.options.frame.shown.reduction.prefilter = false;
    load({});
  }
  return {std::move(scene), std::move(made), std::move(shown)};
}

/// Thrown on all ranks where the viewer has ended while a volume was loaded.
struct Ended {};

/// Loads the first volume, of which the ranks hold `coarse`. Between the portions that are read and dealt
/// they draw a picture of that where a page wants one.
Scene load_behind(const Scene& coarse, SeriesLoader& loader, Job& job, serve::Viewer* viewer,
                  Launch& launch) {
  enum class Act { go_on, draw, end };
  Scene whole;
  job.load.half_of.reset();
  job.load.prefilter = job.options.frame.shown.reduction.prefilter;
  job.load.told = [&](double part, bool) {
    Act act = Act::go_on;
    Director once;
    if (viewer != nullptr) {
      viewer->tell(serve::loading_text((double(whole.others.size()) + part) / double(job.channels_drawn())));
      once = viewer->director();
      auto frames = once.next_picture();
      if (!frames.empty())
        act = Act::draw;
      else if (!once.may_come() && viewer->next_volumes().empty())
        act = Act::end;
      once.may_come = {};
      once.next_picture = [frames = std::move(frames)]() mutable { return std::exchange(frames, {}); };
    }
    act = launch.of_rank_0(act);
    if (act == Act::end) throw Ended();
    if (act == Act::go_on) return;
    const PlainFloats as_while_loading;
    launch.collectives().end_watch();  // frames have their own
    render_all(job, job.options.run.protocol, coarse, std::move(once), launch);
    launch.collectives().begin_watch(fmt::format("reading {}", job.options.volume.path), true);
  };
  loader.load_channels(whole, 0);
  job.load.told = {};
  if (viewer != nullptr) {
    viewer->loaded({{0}, ranges_of(whole)});
    viewer->tell(serve::loading_text(1));
  }
  return whole;
}

/// Shows one volume of the series after another, or two together, as pages ask for them; the next in the same
/// direction is read meanwhile.
void show_series(SeriesLoader& loader, Scene scene, const Job& job, serve::Viewer* viewer, Launch& launch) {
  std::vector<int> held{0};
  if (job.options.more_volumes.size() == 1)
    held = load_next({0, 1}, held, loader, scene, job, viewer, launch);
  bool backwards = false;
  while (true) {
    const std::size_t shown(held.front());
    if (held.size() == 1) loader.read_ahead((backwards ? shown - 1 : shown + 1) * job.channels_drawn());
    render_all(job, job.options.run.protocol, std::exchange(scene, {}),
               viewer != nullptr ? viewer->director() : Director{}, launch);
    const auto next = launch.of_rank_0(viewer != nullptr ? viewer->next_volumes() : std::vector<int>());
    if (next.empty()) return;  // the viewer has ended
    held = load_next(next, held, loader, scene, job, viewer, launch);
    if (std::size_t(held.front()) != shown) backwards = std::size_t(held.front()) < shown;
  }
}

/// What is shown of the volume.
struct Part {
  ServeOptions options;
  bool is_part = false;
  bool is_new = false;  ///< it may turn out that it cannot be shown
};

/// Shows the volume until the viewer ends, or its pages want another part, which is told on rank 0, in voxels
/// of the finest level. `last`: on rank 0, what pages wanted.
std::optional<serve::NextPart> show(const Part& part, const std::optional<serve::NextPart>& last,
                                    Warnings& warnings, Launch& launch) {
  const ServeOptions& options = part.options;
  Job job;  // which the viewer's threads read
  std::unique_ptr<serve::Viewer> viewer;
  job = prepare(options, launch);
  launch.check_on_rank_0([&] {
    if (part.is_new && job.volume.grid.unit_length() >= last->grid.unit_length())
      throw InputError("what is seen does not fit into the memory at a finer level",
                       "zoom in, choose a smaller clip box, or start with more --memory");
  });
  const auto begun = coarse_first(options, job, launch);
  Progress progress(launch.rank() != 0, stderr);
  SeriesLoader loader(job, pictures_held, progress, launch);
  if (!options.picture.more_volumes.empty()) loader.check_all();
  auto [scene, made, first] = load_first(begun, loader, job, launch);
  launch.check_on_rank_0([&] {
    serve::ViewerOptions its = viewer_options(options, job, scene, made, first, launch);
    its.is_part = part.is_part;
    if (last) go_on_as(*last, scene.grid, its);
    viewer = serve::make_viewer(std::move(its));
    if (job.load.half_of) viewer->loaded({{0}, ranges_of(scene), Reduction{2, job.load.prefilter}});
    if (last) return;
    if (options.address != "127.0.0.1" && options.address != "::1")
      log_warning(
          "--bind {}: everybody who can reach this machine and learns the token sees the volume, and what "
          "is sent can be read on the way; a tunnel (ssh -L) is safer",
          options.address);
    fmt::print("{}\n", viewer->url());
    std::fflush(stdout);
  });
  warnings.show_on(viewer.get());
  if (!viewer) leave_the_end_to_rank_0();
  const auto opened = viewer && options.open && !last ? open_in_browser(viewer->url()) : nullptr;
  try {
    if (job.load.half_of) scene = load_behind(scene, loader, job, viewer.get(), launch);
    show_series(loader, std::move(scene), job, viewer.get(), launch);
  } catch (const Ended&) {
    // In order, as after a run.
  } catch (const std::exception& e) {
    if (viewer) viewer->end(e.what());
    warnings.show_on(nullptr);
    throw;
  }
  warnings.show_on(nullptr);
  auto next = viewer ? viewer->next_part() : std::nullopt;
  if (next && next->box) {
    const Grid& finest = finest_of(job.volume);
    next->box = box_in_finest(*next->box, next->grid.spacing / finest.spacing, finest.dims);
  }
  return next;
}

}  // namespace

ExitCode run(const ServeOptions& options, Launch& launch) {
  Warnings warnings;
  Part part{options}, before = part;
  std::optional<serve::NextPart> next;  // on rank 0
  while (true) {
    try {
      next = show(part, next, warnings, launch);
    } catch (const InputError& e) {
      if (!part.is_new) throw;
      if (launch.rank() == 0) log_warning("{}", e.what());
      part = before;
      continue;
    }
    std::optional<std::optional<VoxelBox>> wanted;
    if (next) wanted.emplace(next->box);
    wanted = launch.of_rank_0(wanted);
    if (!wanted) break;
    part.is_new = false;
    before = std::exchange(part, {options});
    if (!*wanted) continue;
    part = {before.options, true, true};
    part.options.picture.volume = part_of(part.options.picture.volume, **wanted);
    part.options.picture.clip = {};
  }
  launch.take_leave();
  return ExitCode::done;
}

}  // namespace ringsplat::app

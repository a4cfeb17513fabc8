#include "app/render_job.hpp"

#include "app/views.hpp"
#include "base/log.hpp"
#include "images/image_file.hpp"
#include "images/image_io.hpp"
#include "net/launcher.hpp"
#include "options/option_tables.hpp"
#include "program/text_output.hpp"

namespace ringsplat::app {

void fields(SeriesEntry& entry, auto& archive) { archive(entry.number, entry.path, entry.frame, entry.name); }

/// Before its transfer function is chosen.
void fields(DrawnChannel& channel, auto& archive) {
  archive(channel.choice, channel.name, channel.colour, channel.window);
}

namespace {

/// Reads the machine that --machine names and adapts the protocol's options to a simulated run. All ranks
/// call it. Throws InputError when the file is bad, or when an option needs a simulation and this is none;
/// warns when --machine has no effect.
void prepare_simulation(RunOptions& options, Launch& launch) {
  ProtocolOptions& protocol = options.protocol;
  SimulationOptions& simulation = options.simulation;
  launch.check_on_all_ranks([&] {
    if (!options.machine.empty()) simulation.machine = read_machine(options.machine);
    if (simulated() && options.threads_per_rank.value_or(1) > 1)
      throw InputError(
          "--threads-per-rank has no meaning for simulated ranks, whose machine says what their work costs",
          "leave it out, and divide the costs in the machine's description by what threads would gain");
  });
  if (!simulated()) {
    if (simulation.machine && launch.rank() == 0)
      log_warning(
          "--machine has no effect here: only simulated ranks have a clock to charge (scripts/simulate.sh)");
    simulation.machine.reset();
  }
  simulate(simulation, options.engine);
  if (!simulated()) return;
  // Simulated time leaps while ranks wait; the simulator itself detects that no rank can go on.
  protocol.stall_timeout = std::numeric_limits<double>::infinity();
}

/// Finds everything wrong with a frame before a voxel is read.
void check_frames(const RenderOptions& o, const std::vector<Camera>& cameras, const Grid& grid) {
  FrameSpec spec = o.frame;
  spec.shown.transfer_function = stand_in_function();
  check(spec);
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    spec.shown.camera = cameras[k];
    try {
      check_frame(spec, grid);
    } catch (const InputError& e) {
      if (cameras.size() == 1) throw;
      throw InputError(fmt::format("frame {}: {}", k, e.what()));
    }
  }
}

/// One camera is for all volumes of a series.
void check_one_camera_each(const std::vector<Camera>& cameras, const RenderOptions& o, std::size_t volumes) {
  if (cameras.size() == volumes || (o.orbit == 0 && o.path.empty())) return;
  throw InputError(fmt::format("{} has {} views, but --frames {} chooses {} volumes",
                               o.orbit > 0 ? "--orbit" : "--path", cameras.size(), o.frames->text, volumes),
                   o.orbit > 0 ? fmt::format("the camera moves on with each volume: give --orbit {}", volumes)
                               : "each line is the view of one volume");
}

/// The pictures of a series of pages may have their names.
void refuse_replacing_volumes(const RenderOptions& o, const std::vector<SeriesEntry>& series) {
  std::error_code error;
  std::set<std::filesystem::path> volumes;
  for (const SeriesEntry& entry : series)
    volumes.insert(std::filesystem::weakly_canonical(entry.path, error));
  for (const SeriesEntry& entry : series) {
    const auto picture = file_of_view(o, o.output, std::size_t(entry.number));
    if (volumes.contains(std::filesystem::weakly_canonical(picture, error)))
      throw InputError(fmt::format("-o {} would replace {}, which is read", o.output, picture.string()),
                       "write into another folder, or under another name");
  }
}

std::array<bool, 3> agree_on_axes(const RenderOptions& o, const std::vector<Camera>& cameras,
                                  const Grid& grid, Launch& launch) {
  std::array<bool, 3> axes{};
  if (launch.rank() == 0) axes = needed_axes(o.frame, cameras, grid);
  return launch.of_rank_0(axes);
}

/// Says on rank 0 why sheets err, unless the error is measured.
void warn_of_errors(const RenderOptions& o, const FrameSpec& frame, const DataRange& range,
                    Progress& progress, const Launch& launch) {
  if (launch.rank() != 0 || o.error.truth || o.run.simulation.count_only) return;
  if (frame.shown.mode != Mode::composite || !std::holds_alternative<Sheets>(frame.how)) return;
  const bool labels = frame.shown.interpolation == Interpolation::nearest;
  const auto why = labels ? why_labels_merge(range) : why_sheets_err(frame.shown.transfer_function, range);
  if (why.empty()) return;
  progress.clear();
  log_warning("{}", why);
}

}  // namespace

void find_volumes(Job& job, Launch& launch) {
  RenderOptions& o = job.options;
  const std::string wanted = o.volume.choice.channel;
  const bool several = names_channels(wanted);
  if (several) o.volume.choice.channel = "all";
  launch.check_on_rank_0([&] { job.series = find_series(o.volume, o.frames, o.more_volumes); });
  job.series = launch.of_rank_0(job.series);
  if (several) {
    launch.check_on_rank_0([&] { job.channels = find_channels(job.part(0), wanted); });
    job.channels = launch.of_rank_0(job.channels);
    if (job.channels.empty()) o.volume.choice.channel.clear();
    o.volume.choice.volumes = int(job.channels_drawn());
  }
  if (o.frames && !o.output.empty()) launch.check_on_rank_0([&] { refuse_replacing_volumes(o, job.series); });
  o.volume = job.part(0);
  job.volume = open(o.volume, launch);
  launch.check_on_rank_0([&] { o.frame.shown.clip = clip_box(o.clip, job.volume.grid, job.volume.notes); });
  o.frame.shown.clip = launch.of_rank_0(o.frame.shown.clip);
}

void check_outputs(const RenderOptions& o) {
  if (!o.output.empty())
    names_film(o.output) ? check_film(o) : check_image_name(o.output, "-o", !o.background);
  if (!o.error.map.empty()) {
    check_image_name(o.error.map, "--error-map", true);
    static_cast<void>(text_mask("0", 12));  // the scale's letters
  }
  const std::vector<NamedFile> outputs{{"-o", o.output},
                                       {"--error-map", o.error.map},
                                       {"--stats", o.stats},
                                       {"--trace", o.trace},
                                       {"--tf-out", o.transfer_function_out}};
  for (const auto& [option, file] : outputs)
    if (!file.empty()) check_can_write_text(file, option);
  refuse_clashes(outputs, {{"the volume", o.volume.path}, {"--path", o.path}, {"--tf", o.transfer_function}});
}

std::size_t pictures_at_once(const Job& job, std::size_t views) {
  const RenderOptions& o = job.options;
  const auto in_flight = std::size_t(o.run.protocol.frames_in_flight);
  return std::size_t(!job.channels.empty() || in_several_frames(o)) +
         (o.error.truth ? std::max(in_flight, views) : in_flight + std::min(views, FrameWriter::room + 1));
}

Job prepare(const RenderOptions& given, Launch& launch) {
  Job job;
  RenderOptions& o = job.options = given;
  prepare_simulation(o.run, launch);
  settle_ranks(job, launch);
  // Planes are kept for later views of the same volume; of one view that would only take memory and time.
  const bool one_view = (o.frames || (o.orbit <= 1 && o.path.empty())) && !in_several_frames(o);
  if (one_view && !o.run.engine.keep) o.run.engine.keep = 0;
  o.run.engine.encodes_pictures = !o.output.empty();
  launch.check_on_rank_0([&] {
    job.transfer_function.emplace(o.transfer_function, o.colour);
    check_outputs(o);
  });
  if ((o.frames || names_channels(o.volume.choice.channel)) && simulated())
    throw InputError(
        "--frames, --channel: the next volume is read by the clock on the wall, not the simulated one",
        "simulate one volume and channel at a time");
  find_volumes(job, launch);
  const Grid& grid = job.volume.grid;
  std::string view_note;
  launch.check_on_rank_0([&] {
    view_note = complete_view(o, grid, job.volume.notes);
    job.cameras = views_of(o);
    if (o.frames) check_one_camera_each(job.cameras, o, job.series.size());
    check_frames(o, job.cameras, grid);
    if (o.annotate)
      job.annotation.emplace(grid, job.volume.notes, o.background, o.colour.range, job.channels);
  });
  job.load = needed_along(o.frame, agree_on_axes(o, job.cameras, grid, launch));
  if (o.budget.max_error && !o.budget.fixed.contains("--undersample"))
    job.load.factors.assign(undersampling.begin(), undersampling.end());
  settle_layout(job, pictures_at_once(job, job.cameras.size()), job.channels_drawn(), launch);
  if (launch.rank() == 0 && (!o.output.empty() || !o.error.map.empty()))
    job.image_library = load_image_library(!simulated());
  if (!view_note.empty()) log_info("{}", view_note);
  return job;
}

Scene reload(Job& job, Progress& progress, Launch& launch) {
  const Facts before = std::exchange(job.volume, open(job.options.volume, launch)).facts;
  launch.check_on_rank_0([&] {
    if (job.volume.facts != before)
      throw InputError(fmt::format("{} has changed since it was first read", job.options.volume.path),
                       "start again when nobody writes to it any more");
  });
  return load(job, job.volume, progress, launch);
}

FrameSpec choose_frame(Job& job, Scene& scene, Progress& progress, Launch& launch, std::size_t channel) {
  const RenderOptions& o = job.options;
  FrameSpec frame = o.frame;
  launch.check_on_rank_0([&] {
    const MadeFunction made = job.channels.empty()
                                  ? job.transfer_function->make(scene.values, frame.shown)
                                  : make_function(job.channels[channel], o, scene.values, frame.shown);
    const TransferFunction& function = frame.shown.transfer_function;
    check(function, o.transfer_function);
    if (job.image_library.valid()) job.image_library.get();
    if (!o.transfer_function_out.empty())
      write_text_output(o.transfer_function_out, to_paraview_json(function));
    if (!made.said.empty() && !simulated()) progress.print(made.said);
  });
  const ShownLabels& mask = o.volume.mask;
  const bool hides = !mask.path.empty() && mask.covered == Covered::alone;
  if (launch.rank() == 0) {
    frame.shown.tints = tints_of(mask, scene.labels);
    if (hides && !(scene.values.range.low < scene.values.range.high))
      log_warning(
          "{} covers nothing of the volume, or one value alone; hint: ringsplat info says where both lie",
          printable(mask.path));
  }
  if (o.budget.max_error) keep_budget(job, scene, frame, progress, launch);
  const Histogram& without_outliers = scene.values.histogram;
  warn_of_errors(o, frame, {without_outliers.low, without_outliers.high}, progress, launch);
  return frame;
}

std::vector<FrameSpec> choose_frames(Job& job, Scene& scene, Progress& progress, Launch& launch) {
  std::vector<FrameSpec> frames;
  for (std::size_t k = 0; k < job.channels_drawn(); ++k)
    frames.push_back(choose_frame(job, k == 0 ? scene : scene.others[k - 1], progress, launch, k));
  return frames;
}

Director director_of(const Job& job, std::size_t volume, const std::vector<FrameSpec>& frames,
                     std::function<void(FrameResult&&)> take) {
  std::vector<Camera> cameras = job.cameras;
  if (job.options.frames && cameras.size() > 1) cameras = {cameras[volume]};
  Director director;
  director.next_picture = [frames = frames, cameras, next = std::size_t{0}]() mutable {
    std::vector<VolumeFrame> picture;
    for (std::size_t k = 0; next < cameras.size() && k < frames.size(); ++k) {
      frames[k].shown.camera = cameras[next];
      picture.push_back({k, frames[k]});
    }
    ++next;
    return picture;
  };
  director.frame_done = [&job, volume, take = std::move(take)](FrameResult&& result) {
    if (job.options.frames) result.spec.frame = result.stats.frame = job.series[volume].number;
    take(std::move(result));
  };
  return director;
}

}  // namespace ringsplat::app

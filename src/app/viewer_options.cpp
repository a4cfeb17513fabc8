#include "app/viewer_options.hpp"

#include "app/error_map.hpp"
#include "base/srgb.hpp"
#include "classify/auto_preset.hpp"
#include "formats/label_notes.hpp"
#include "program/layouts.hpp"

namespace ringsplat::app {
namespace {

std::vector<serve::Label> labels_of(const std::vector<double>& values,
                                    const std::map<double, detail::LabelNotes>& notes) {
  std::vector<serve::Label> labels;
  for (const double value : values) {
    const auto of_file = notes.find(value);
    if (value != 0) labels.push_back({value, of_file == notes.end() ? "" : of_file->second.name});
  }
  return labels;
}

/// The channels, each with its own function in each mode, in white. That of the first was told.
void add_channels(const Job& job, const Scene& scene, serve::ViewerOptions& v) {
  for (std::size_t k = 0; k < job.channels.size(); ++k) {
    const ValueStatistics& values = k == 0 ? scene.values : scene.others[k - 1].values;
    DrawnChannel channel = job.channels[k];
    RenderOptions options = job.options;
    Shown ignored;
    if (k > 0) fmt::print(stderr, "{}\n", make_function(channel, options, values, ignored).said);
    channel.colour = glm::dvec3(1.0);
    serve::ShownChannel& shown = v.channels.emplace_back();
    shown.name = channel.name;
    for (const Mode mode : every_mode) {
      options.colour.mode = mode;
      make_function(channel, options, values, shown.own[mode]);
    }
    v.initial.channels.push_back({true, job.channels[k].colour, shown.window(v.initial.shown.mode)});
  }
}

}  // namespace

std::vector<ValueRange> ranges_of(const Scene& scene) {
  std::vector<ValueRange> ranges{scene.values.range};
  for (const Scene& other : scene.others) ranges.push_back(other.values.range);
  return ranges;
}

const Grid& finest_of(const OpenedVolume& volume) {
  return volume.notes.finest ? *volume.notes.finest : volume.grid;
}

void go_on_as(const serve::NextPart& part, const Grid& grid, serve::ViewerOptions& v) {
  v.server = part.server;
  v.part = part.number;
  const Camera whole = v.initial.shown.camera;
  v.initial = part.scene;
  if (facts_of(grid) == facts_of(part.grid)) return;  // the part could not be shown
  Shown& shown = v.initial.shown;
  shown.camera.zoom = whole.zoom;
  shown.camera.pan = whole.pan;
  shown.clip.reset();
  shown.clip_planes.clear();
  v.initial.cut.reset();
  if (shown.mode == Mode::composite)
    scale_opacity(shown.transfer_function, grid.unit_length() / part.grid.unit_length());
}

serve::ViewerOptions viewer_options(const ServeOptions& options, const Job& job, const Scene& scene,
                                    const MadeFunction& made, const Shown& first, const Launch& launch) {
  const RenderOptions& o = job.options;
  serve::ViewerOptions v;
  v.layout =
      fmt::format("{}, {}", describe(job.layout), job.layout.topology == Topology::ring ? "ring" : "mesh");
  v.ranks = launch.ranks();
  const std::filesystem::path path = o.volume.path;
  const AutoChoice usual = choose_function(scene.values);
  v.volume = {(path.has_filename() ? path : path.parent_path()).filename().string(),
              scene.grid,
              scene.values.notes.world == World::patient,
              scene.values.notes.unit,
              usual.hounsfield,
              ranges_of(scene),
              scene.values.histogram};
  v.frames.clear();
  for (const SeriesEntry& volume : job.series) v.frames.push_back(volume.name);
  v.frame = o.frame;
  v.initial.shown = first;
  if (o.more_volumes.size() == 1) v.initial.compared = 1;
  if (!made.said.empty()) fmt::print(stderr, "{}\n", made.said);
  v.initial.shown.tints = tints_of(o.volume.mask, scene.labels);
  v.segments = labels_of(scene.labels, notes_of(o.volume.mask));
  serve::set_modes(usual.function, scene.values, v);
  check(v.initial.shown.transfer_function, o.transfer_function);
  add_channels(job, scene, v);
  if (made.labels && job.channels.empty())
    v.volume.labels = labels_of(scene.values.labels, detail::label_notes(o.volume.path));
  v.initial.background = linear_to_srgb(o.background.value_or(glm::dvec3(0.0)));
  v.target_seconds = options.target_ms / 1e3;
  v.errors = [&job](const FrameResult& picture, int volume, const std::function<void()>& go_on) {
    return proved_errors(job, picture, volume, go_on);
  };
  v.finer = finest_of(job.volume).dims != scene.grid.dims;
  v.server = {options.address, options.port, options.allowed_hosts, options.allowed_origins,
              options.allowed_frames};
  return v;
}

}  // namespace ringsplat::app

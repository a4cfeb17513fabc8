#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/channels.hpp"
#include "app/commands.hpp"
#include "app/views.hpp"
#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/process.hpp"
#include "forecast/forecast.hpp"
#include "options/option_tables.hpp"
#include "program/layouts.hpp"
#include "program/progress.hpp"
#include "program/text_output.hpp"
#include "record/stats.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "scene/scene.hpp"
#include "session/render.hpp"
#include "volume/clipped.hpp"
#include "volume/slice_store.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat::app {
namespace {

constexpr int json_bins = 64, shown_bins = 16;
constexpr double shown_shares[] = {0, 0.001, 0.01, 0.25, 0.5, 0.75, 0.99, 0.999, 1};

ValueStatistics read_values(VolumeSource& source, Progress& progress) {
  const Grid& grid = source.grid();
  int passes = 0;
  const Pass pass = [&](const RowVisitor& visit) {
    progress.begin(passes++ == 0 ? "reading the values" : "reading the values again", grid.dims.z);
    visit_slices(source, 0, grid.dims.z, visit);
    progress.end();
  };
  return describe_values(grid, source.notes(), pass);
}

std::string human_bytes(std::uint64_t bytes) {
  constexpr const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB", "PiB"};
  double value = double(bytes);
  std::size_t unit = 0;
  for (; value >= 1024 && unit + 1 < std::size(units); ++unit) value /= 1024;
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.1f} {}", value, units[unit]);
}

/// What memory_of() tells, in its order: as JSON calls it, and as people are told.
constexpr std::pair<const char*, const char*> memory_names[] = {{"all_axes_lit", "all axes, lit"},
                                                                {"all_axes_unlit", "all axes, unlit"},
                                                                {"one_axis_lit", "one axis, lit"},
                                                                {"one_axis_unlit", "one axis, unlit"},
                                                                {"kept_by_a_renderer", "kept"}};

/// Bytes of the GP that holds most, and of sheets that a Renderer keeps.
std::array<std::uint64_t, std::size(memory_names)> memory_of(const Grid& grid, SliceDealing dealing) {
  const auto of = [&](std::array<bool, 3> axes, bool normals) {
    return SliceStore::bytes_needed(grid, 0, dealing, axes, normals);
  };
  const auto of_one = [&](bool normals) {
    return std::max({of({true}, normals), of({false, true}, normals), of({false, false, true}, normals)});
  };
  return {of({true, true, true}, true), of({true, true, true}, false), of_one(true), of_one(false),
          usual_kept_bytes(grid, dealing.gps)};
}

std::vector<int> counts_of_gps(const InfoOptions& o) {
  return o.gps > 0 ? std::vector{o.gps} : std::vector{1, 2, 4, 8, 16};
}

std::string triple_text(const glm::dvec3& v, const char* between) {
  return fmt::format("{:g}{}{:g}{}{:g}", plain(v.x), between, plain(v.y), between, plain(v.z));
}

/// Bars show the square root of counts: the air around an object would flatten all others.
std::string histogram_text(const ValueStatistics& values) {
  const Histogram histogram = coarser(values.histogram, shown_bins);
  const double highest = std::sqrt(double(*std::ranges::max_element(histogram.counts)));
  const double total = double(std::max<std::uint64_t>(1, values.range.finite));
  std::string text = "histogram  (bars by the square root)\n";
  const auto outside = [&](std::uint64_t count, const char* where, double from, double to) {
    if (count > 0)
      text += fmt::format("  {:>12}  {:>6.2f} %  {} voxel{} from {:g} to {:g}\n", where,
                          100 * double(count) / total, count, count == 1 ? "" : "s", plain(from), plain(to));
  };
  outside(histogram.below, "below", values.range.low, histogram.low);
  for (std::size_t k = 0; k < histogram.counts.size(); ++k) {
    const double count = double(histogram.counts[k]);
    const double from = std::lerp(histogram.low, histogram.high, double(k) / shown_bins);
    const auto length = highest > 0 ? static_cast<std::size_t>(40 * std::sqrt(count) / highest + 0.5) : 0;
    text += fmt::format("  {:>12.6g}  {:>6.2f} %  {}\n", plain(from), 100 * count / total,
                        std::string(length, '#'));
  }
  outside(histogram.above, "above", histogram.high, values.range.high);
  return text;
}

std::string quantiles_text(const ValueStatistics& values) {
  std::string shares, found;
  for (const double share : shown_shares) {
    shares += fmt::format("{:>11}", fmt::format("{:g} %", 100 * share));
    found += fmt::format("{:>11.5g}", plain(values.quantile(share)));
  }
  return fmt::format("quantiles{}\n         {}\n", shares, found);
}

const char* name(World world) {
  constexpr const char* names[] = {"lattice", "patient", "microscope"};
  return names[static_cast<int>(world)];
}

/// What the file says beside the lattice, as name and value; nothing of what it does not say.
std::vector<std::pair<const char*, std::string>> rows_of(const ValueStatistics& values, int frame) {
  const VolumeNotes& notes = values.notes;
  std::vector<std::pair<const char*, std::string>> rows;
  const auto row = [&](const char* what, const std::string& text) {
    if (!text.empty()) rows.emplace_back(what, text);
  };
  row("world", notes.world == World::patient ? "patient: left, posterior, superior, in mm"
               : notes.world == World::microscope
                   ? "microscope: columns, rows downwards, away from the viewer"
                   : "");
  row("unit", notes.unit);
  row("quantity", notes.quantity);
  row("modality", notes.modality);
  row("frames", notes.frames > 1 ? fmt::format("time point {} of {}, --frame N takes another, 0 to {}",
                                               frame + 1, notes.frames, notes.frames - 1)
                                 : "");
  row("channels", notes.channels > 1 ? fmt::format("{}, --channel chooses one", notes.channels) : "");
  if (notes.labels || look_like_labels(values))
    row("labels", fmt::format("{} different values{}", values.labels.size(), notes.labels ? "" : ", found"));
  if (notes.fill) row("fill value", fmt::format("{:g}, {} voxels", *notes.fill, values.fill_voxels));
  return rows;
}

/// The volume's channels as --channel all draws them; what it leaves out is hidden, and as the file says.
std::vector<ChannelNotes> channels_of(const VolumeOptions& volume, const VolumeNotes& notes) {
  std::vector<ChannelNotes> channels = notes.of_channels;
  if (notes.channels == 1) return {};
  channels.resize(std::size_t(notes.channels));
  for (std::size_t k = 0; k < channels.size(); ++k) {
    channels[k].hidden = true;
    if (channels[k].name.empty()) channels[k].name = fmt::format("channel {}", k);
  }
  try {
    for (const DrawnChannel& drawn : find_channels(volume, "all")) {
      ChannelNotes& channel = channels[std::stoul(drawn.choice)];
      channel = {channel.name, drawn.colour, drawn.window};
    }
  } catch (const InputError&) {  // more than one picture can have
  }
  return channels;
}

nlohmann::json to_json(const ChannelNotes& channel) {
  nlohmann::json j{{"name", channel.name}, {"colour", {}}, {"window", {}}, {"drawn", !channel.hidden}};
  if (const auto& colour = channel.colour) j["colour"] = {colour->x, colour->y, colour->z};
  if (channel.window) j["window"] = {channel.window->x, channel.window->y};
  return j;
}

std::string to_text(const ChannelNotes& channel) {
  std::string text = excerpt(channel.name);
  if (channel.colour) {
    const glm::ivec3 rgb(255.0 * *channel.colour + 0.5);
    text += fmt::format(", #{:02x}{:02x}{:02x}", rgb.x, rgb.y, rgb.z);
  }
  if (const auto& window = channel.window)
    text += fmt::format(", values from {:g} to {:g}", window->x, window->y);
  return text + (channel.hidden ? "; not in --channel all" : "");
}

/// What info has found in the part of the volume that is shown.
struct Found {
  Grid whole, part;
  ValueStatistics values;
  bool concurrent;
  std::vector<ChannelNotes> channels;
};

/// GPs hold whole slices, whatever part is shown.
std::string to_text(const InfoOptions& o, const Found& found) {
  const auto& [whole, grid, values, concurrent, channels] = found;
  const glm::dvec3 extent = glm::dvec3(grid.dims) * grid.spacing;
  std::string text;
  const auto row = [&](const std::string& name, const std::string& value) {
    text += fmt::format("{:<11}{}\n", name, value);
  };
  row("volume", o.picture.volume.path);
  if (const auto clip = clip_box(o.picture.clip, whole, values.notes))
    row("clip", fmt::format("{} of {}", text_of(*clip), detail::product_of(whole.dims)));
  row("shape", fmt::format("{}, {} voxels", detail::product_of(grid.dims), grid.voxels()));
  row("type", fmt::format("{}, {} in all", to_string(grid.type), human_bytes(grid.bytes())));
  row("spacing", triple_text(grid.spacing, " x "));
  row("origin", triple_text(grid.origin, " "));
  const auto& d = grid.direction;
  row("directions", fmt::format("({})  ({})  ({})", triple_text(d[0], " "), triple_text(d[1], " "),
                                triple_text(d[2], " ")));
  row("size", triple_text(extent, " x "));
  row("reading", concurrent ? "by all ranks at once" : "decoded by rank 0");
  for (const auto& [what, value] : rows_of(values, o.picture.volume.choice.frame.value_or(0)))
    row(what, value);
  for (std::size_t k = 0; k < channels.size(); ++k) row(fmt::format("channel {} ", k), to_text(channels[k]));
  row("range", values.range.empty()
                   ? "no finite value"
                   : fmt::format("{:g} to {:g}", plain(values.range.low), plain(values.range.high)));
  row("not finite", fmt::format("{} voxels", values.range.not_finite));
  if (!values.range.empty()) text += quantiles_text(values) + histogram_text(values);
  text += fmt::format(
      "\nslices held by a GP{} (while loading up to 64 MiB more), and kept by a Renderer for later frames "
      "(--keep)\n  {:>8}",
      o.bundle > 1 ? fmt::format(", in bundles of {}", o.bundle) : "", "--gps");
  for (const auto& [key, what] : memory_names) text += fmt::format("{:>18}", what);
  for (const int gps : counts_of_gps(o)) {
    text += fmt::format("\n  {:>8}", gps);
    for (const auto bytes : memory_of(whole, {gps, o.bundle}))
      text += fmt::format("{:>18}", human_bytes(bytes));
  }
  return text + "\n";
}

nlohmann::json to_json(const ValueStatistics& values) {
  const VolumeNotes& notes = values.notes;
  nlohmann::json j{{"world", name(notes.world)}, {"frames", notes.frames}, {"channels", notes.channels}};
  for (const auto& [what, text] :
       {std::pair("unit", &notes.unit), {"quantity", &notes.quantity}, {"modality", &notes.modality}})
    j[what] = text->empty() ? nlohmann::json() : nlohmann::json(*text);
  j["fill"] = notes.fill ? nlohmann::json(*notes.fill) : nlohmann::json();
  j["fill_voxels"] = values.fill_voxels;
  j["labels"] = notes.labels || look_like_labels(values) ? nlohmann::json(values.labels) : nlohmann::json();
  return j;
}

nlohmann::json to_json(const InfoOptions& o, const Found& found) {
  const auto& [whole, grid, values, concurrent, channels] = found;
  nlohmann::json j;
  const auto triple = [](const auto& v) { return nlohmann::json{v.x, v.y, v.z}; };
  j["volume"] = o.picture.volume.path;
  if (const auto clip = clip_box(o.picture.clip, whole, values.notes))
    for (int k = 0; k < 3; ++k) j["clip"].push_back({clip->first[k], clip->end[k]});
  j["dims"] = triple(grid.dims);
  j["voxels"] = grid.voxels();
  j["type"] = to_string(grid.type);
  j["bytes"] = grid.bytes();
  j["spacing"] = triple(grid.spacing);
  j["origin"] = triple(grid.origin);
  j["directions"] = {triple(grid.direction[0]), triple(grid.direction[1]), triple(grid.direction[2])};
  j["size"] = triple(glm::dvec3(grid.dims) * grid.spacing);
  j["concurrent_reading"] = concurrent;
  const ValueRange& range = values.range;
  j["range"] = range.empty() ? nlohmann::json() : nlohmann::json{range.low, range.high};
  j["finite"] = range.finite;
  j["not_finite"] = range.not_finite;
  j["quantiles"] = nlohmann::json::array();
  for (const double share : shown_shares)
    if (!range.empty()) j["quantiles"].push_back({{"share", share}, {"value", values.quantile(share)}});
  const Histogram histogram = coarser(values.histogram, json_bins);
  j["histogram"] = {{"low", histogram.low},
                    {"high", histogram.high},
                    {"counts", histogram.counts},
                    {"below", histogram.below},
                    {"above", histogram.above}};
  j["notes"] = to_json(values);
  for (const ChannelNotes& channel : channels) j["channels"].push_back(to_json(channel));
  for (const int gps : counts_of_gps(o)) {
    nlohmann::json& row = j["slice_memory_of_a_gp"].emplace_back();
    row = {{"gps", gps}, {"bundle", o.bundle}};
    const auto memory = memory_of(whole, {gps, o.bundle});
    for (std::size_t k = 0; k < memory.size(); ++k) row[memory_names[k].first] = memory[k];
  }
  return j;
}

/// The prediction that --ranks asks for.
struct Foreseen {
  Machine machine;
  bool described = false;  ///< or this one
  FrameWork work;
  std::vector<Prediction> predictions;
};

Foreseen foresee(const InfoOptions& o, VolumeSource& source, Progress& progress) {
  RenderOptions picture = o.picture;
  if (const auto note = complete_view(picture, source.grid(), source.notes()); !note.empty()) {
    progress.clear();
    log_info("{}", note);
  }
  const auto cameras = views_of(picture);
  picture.frame.shown.clip = clip_box(picture.clip, source.grid(), source.notes());
  const int cores = o.cores > 0 ? o.cores : int(allowed_cores().size());
  Foreseen f;
  f.described = !o.machine.empty();
  f.machine = f.described ? read_machine(o.machine) : this_machine(1, cores);
  progress.begin("predicting frames", 0);
  Forecast forecast(source, picture.frame,
                    TransferFunctionChoice(o.picture.transfer_function, o.picture.colour),
                    some_views(cameras), f.machine, 1, o.ranks, picture.run.protocol);
  f.work = forecast.work();
  const auto layouts = possible_layouts(o.ranks, true, ranks_with_own_cores(f.machine, o.ranks));
  f.predictions = forecast.predict_all(in_bundles(layouts, o.bundle));
  progress.end();
  return f;
}

/// That the ranks share.
int cores_of(const Machine& machine, int ranks) {
  return machine.platform.hosts > 0 ? machine.platform.hosts * machine.platform.cores : ranks;
}

std::string to_text(const Foreseen& f, int ranks) {
  return fmt::format("\na frame on {} ranks that share {} cores\n  {}: {}\n{}best: {}\n", ranks,
                     cores_of(f.machine, ranks), f.machine.name, describe(f.work), to_table(f.predictions),
                     describe(f.predictions.front().layout));
}

nlohmann::json to_json(const Foreseen& f, int ranks) {
  nlohmann::json layouts = nlohmann::json::array();
  for (const Prediction& p : f.predictions) {
    nlohmann::json& row = layouts.emplace_back(to_json(p.layout));
    row.update({{"layout", describe(p.layout)},
                {"seconds", p.seconds},
                {"gp_seconds", p.gp},
                {"renderer_seconds", p.renderer},
                {"core_seconds", p.shared},
                {"token_seconds", p.tokens},
                {"limit", p.limit}});
  }
  return {{"machine", f.described ? nlohmann::json(f.machine.name) : nlohmann::json()},
          {"cores", cores_of(f.machine, ranks)},
          {"gp_seconds", f.work.gp},
          {"gp_frame_seconds", f.work.frame},
          {"renderer_seconds", f.work.renderer},
          {"visible_voxels", f.work.visible_voxels},
          {f.work.items_name, f.work.items},
          {"layouts", layouts}};
}

std::string list_of_presets() {
  std::string text;
  for (const auto& preset : preset_names())
    text += fmt::format("{:<14}{}\n", preset.name, preset.description);
  return text + "\ncolour maps for --colours\n" + list_of_colour_maps();
}

nlohmann::json json_of_presets() {
  auto list = nlohmann::json::array();
  for (const auto& preset : preset_names())
    list.push_back({{"name", preset.name}, {"description", preset.description}});
  return list;
}

}  // namespace

ExitCode run(const InfoOptions& o) {
  if (o.presets) {
    write_text_output("-", o.json ? plain_json_text(json_of_presets(), 2) + "\n" : list_of_presets());
    return ExitCode::done;
  }
  Progress progress;
  WatchedSource source(open_volume(o.picture.volume), [&](int slices) { progress.at(slices); });
  const auto clip = clip_box(o.picture.clip, source.grid(), source.notes());
  const auto part = clipped_source(source, clip.value_or(whole_box(source.grid())));
  const Found found{source.grid(), part->grid(), read_values(clip ? *part : source, progress),
                    source.concurrent(), channels_of(o.picture.volume, source.notes())};
  std::optional<Foreseen> predicted;
  if (o.ranks > 0) predicted = foresee(o, source, progress);
  const auto series = source.notes().series;
  if (o.json) {
    auto j = to_json(o, found);
    if (predicted) j["prediction"] = to_json(*predicted, o.ranks);
    if (!series.empty()) j["series"] = series;
    write_text_output("-", plain_json_text(std::move(j), 2) + "\n");
  } else {
    std::string text = to_text(o, found) + (predicted ? to_text(*predicted, o.ranks) : "");
    if (!series.empty())
      text += fmt::format("\nseries in this folder (--series takes one)\n  {}\n", joined(series, "\n  "));
    write_text_output("-", text);
  }
  return ExitCode::done;
}

}  // namespace ringsplat::app

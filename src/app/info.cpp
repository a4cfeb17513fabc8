#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "app/commands.hpp"
#include "app/first_view.hpp"
#include "app/frame_output.hpp"
#include "app/json_text.hpp"
#include "app/probe.hpp"
#include "app/progress.hpp"
#include "app/role_choice.hpp"
#include "app/watched_source.hpp"
#include "base/log.hpp"
#include "base/printable.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "volume/clipped.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat::app {
namespace {

constexpr int bins = 64, shown_bins = 16;
constexpr std::array<bool, 3> all_sets{true, true, true};

struct Contents {
  ValueRange range;
  Histogram histogram;
};

template <class F>
void for_each_batch(VolumeSource& source, F&& f) {
  const Grid& grid = source.grid();
  constexpr std::size_t batch_bytes = std::size_t{8} << 20;
  const std::size_t slice = grid.slice_bytes(Axis::z);
  const int batch =
      static_cast<int>(std::clamp<std::size_t>(batch_bytes / slice, 1, std::size_t(grid.dims.z)));
  std::vector<std::byte> voxels(slice * std::size_t(batch));
  for (int z = 0; z < grid.dims.z; z += batch) {
    const int count = std::min(batch, grid.dims.z - z);
    const std::span<std::byte> part(voxels.data(), slice * std::size_t(count));
    source.read_slices(z, count, part);
    f(std::span<const std::byte>(part));
  }
}

/// Two passes: the histogram's bins need the range first.
Contents read_contents(VolumeSource& source, Progress& progress) {
  Contents contents;
  const Grid& grid = source.grid();
  progress.begin("reading the range", grid.dims.z);
  for_each_batch(source, [&](std::span<const std::byte> v) { contents.range.add(grid.type, v); });
  progress.end();
  if (contents.range.empty()) return contents;
  contents.histogram = Histogram(contents.range.low, contents.range.high, bins);
  progress.begin("reading the histogram", grid.dims.z);
  for_each_batch(source, [&](std::span<const std::byte> v) { contents.histogram.add(grid.type, v); });
  progress.end();
  return contents;
}

std::string human_bytes(std::uint64_t bytes) {
  constexpr const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB", "PiB"};
  double value = double(bytes);
  std::size_t unit = 0;
  for (; value >= 1024 && unit + 1 < std::size(units); ++unit) value /= 1024;
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.1f} {}", value, units[unit]);
}

struct Memory {
  int gps;
  std::uint64_t all_lit, all_plain, one_lit, one_plain;  ///< bytes of the GP that holds most
};

Memory memory_of(const Grid& grid, int gps) {
  const auto most = [&](bool all, bool normals) {
    if (all) return SliceStore::bytes_needed(grid, 0, gps, all_sets, normals);
    std::uint64_t largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<bool, 3> one{};
      one[axis] = true;
      largest = std::max(largest, SliceStore::bytes_needed(grid, 0, gps, one, normals));
    }
    return largest;
  };
  return {gps, most(true, true), most(true, false), most(false, true), most(false, false)};
}

std::vector<Memory> memory_table(const Grid& grid, int gps) {
  std::vector<Memory> table;
  for (const int count : gps > 0 ? std::vector{gps} : std::vector{1, 2, 4, 8, 16})
    table.push_back(memory_of(grid, count));
  return table;
}

std::string triple_text(const glm::dvec3& v, const char* between) {
  return fmt::format("{:g}{}{:g}{}{:g}", plain(v.x), between, plain(v.y), between, plain(v.z));
}

std::string matrix_text(const glm::dmat3& m) {
  return fmt::format("({})  ({})  ({})", triple_text(m[0], " "), triple_text(m[1], " "),
                     triple_text(m[2], " "));
}

/// Bars show the square root of counts: the air around an object would flatten all others.
std::string histogram_text(const Histogram& histogram) {
  std::vector<std::uint64_t> counts(shown_bins);
  for (std::size_t k = 0; k < histogram.counts.size(); ++k)
    counts[k * shown_bins / histogram.counts.size()] += histogram.counts[k];
  const double highest = std::sqrt(double(*std::max_element(counts.begin(), counts.end())));
  const double total = double(std::max<std::uint64_t>(1, histogram.total()));
  std::string text = "histogram  (bars by the square root)\n";
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const double from = histogram.low + (histogram.high - histogram.low) * double(k) / shown_bins;
    const auto length =
        highest > 0 ? static_cast<std::size_t>(40 * std::sqrt(double(counts[k])) / highest + 0.5) : 0;
    text += fmt::format("  {:>12.6g}  {:>6.2f} %  {}\n", plain(from), 100 * double(counts[k]) / total,
                        std::string(length, '#'));
  }
  return text;
}

std::string range_text(const VoxelBox& box, int k) { return fmt::format("{}:{}", box.first[k], box.end[k]); }

/// `grid` and contents are the clipped part's; GPs hold whole slices.
std::string to_text(const InfoOptions& o, const Grid& whole, const Grid& grid, const Contents& c,
                    bool concurrent) {
  const glm::dvec3 extent = glm::dvec3(grid.dims) * grid.spacing;
  std::string text;
  const auto row = [&](const char* name, const std::string& value) {
    text += fmt::format("{:<11}{}\n", name, value);
  };
  row("volume", o.volume.path);
  if (const auto clip = clip_box(o.picture.clip, whole))
    row("clip", fmt::format("{},{},{} of {} x {} x {}", range_text(*clip, 0), range_text(*clip, 1),
                            range_text(*clip, 2), whole.dims.x, whole.dims.y, whole.dims.z));
  row("shape", fmt::format("{} x {} x {}, {} voxels", grid.dims.x, grid.dims.y, grid.dims.z, grid.voxels()));
  row("type", fmt::format("{}, {} in all", to_string(grid.type), human_bytes(grid.bytes())));
  row("spacing", triple_text(grid.spacing, " x "));
  row("origin", triple_text(grid.origin, " "));
  row("directions", matrix_text(grid.direction));
  row("size", triple_text(extent, " x "));
  row("reading", concurrent ? "by all ranks at once" : "decoded by rank 0");
  row("range", c.range.empty() ? "no finite value"
                               : fmt::format("{:g} to {:g}", plain(c.range.low), plain(c.range.high)));
  row("not finite", fmt::format("{} voxels", c.range.not_finite));
  if (!c.range.empty()) text += histogram_text(c.histogram);
  text += fmt::format(
      "\nslices held by a GP (while loading up to 64 MiB more)\n  {:>8}{:>18}{:>18}{:>18}{:>18}\n", "--gps",
      "all axes, lit", "all axes, unlit", "one axis, lit", "one axis, unlit");
  for (const auto& m : memory_table(whole, o.gps))
    text += fmt::format("  {:>8}{:>18}{:>18}{:>18}{:>18}\n", m.gps, human_bytes(m.all_lit),
                        human_bytes(m.all_plain), human_bytes(m.one_lit), human_bytes(m.one_plain));
  return text;
}

nlohmann::json to_json(const InfoOptions& o, const Grid& whole, const Grid& grid, const Contents& c,
                       bool concurrent) {
  nlohmann::json j;
  const auto triple = [](const auto& v) { return nlohmann::json{v.x, v.y, v.z}; };
  j["volume"] = o.volume.path;
  if (const auto clip = clip_box(o.picture.clip, whole))
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
  j["range"] = c.range.empty() ? nlohmann::json() : nlohmann::json{c.range.low, c.range.high};
  j["finite"] = c.range.finite;
  j["not_finite"] = c.range.not_finite;
  j["histogram"] = {{"low", c.histogram.low}, {"high", c.histogram.high}, {"counts", c.histogram.counts}};
  for (const auto& m : memory_table(whole, o.gps))
    j["slice_memory_of_a_gp"].push_back({{"gps", m.gps},
                                         {"all_axes_lit", m.all_lit},
                                         {"all_axes_unlit", m.all_plain},
                                         {"one_axis_lit", m.one_lit},
                                         {"one_axis_unlit", m.one_plain}});
  return j;
}

/// The prediction that --ranks asks for.
struct Forecast {
  FrameCosts costs;
  RankCosts ranks;
  std::vector<Prediction> predictions;
  std::optional<Machine> machine;  ///< the machine to predict for; none: this one
};

Forecast forecast(const InfoOptions& o, VolumeSource& source, Progress& progress) {
  if (o.picture.path == "-")
    throw InputError("info takes no views from stdin", "write them into a file for --path");
  if (!o.machine.empty() && std::holds_alternative<Sheets>(o.picture.frame.how))
    throw InputError("a described machine has costs of splats only, so --machine cannot predict sheets",
                     "add --quality paper, or leave out --machine");
  RenderOptions picture = o.picture;
  if (const auto note = complete_view(picture, source.grid(), source.notes()); !note.empty()) {
    progress.clear();
    log_info("{}", note);
  }
  const auto cameras = views_of(picture);
  picture.frame.shown.clip = clip_box(picture.clip, source.grid());
  const FrameSpec& frame = picture.frame;
  const auto axes =
      needed_axes(cameras, source.grid(), frame.shown.width, frame.shown.height, frame.shown.clip);
  const int cores = o.cores > 0 ? o.cores : int(std::max(1U, std::thread::hardware_concurrency()));
  Forecast f;
  if (!o.machine.empty()) f.machine = read_machine(o.machine);
  progress.begin("measuring a frame", 0);
  f.costs = measure_frame_costs(source, frame, TransferFunctionChoice(o.picture.transfer_function),
                                probe_views(cameras), load_options(picture, axes),
                                f.machine ? &*f.machine : nullptr);
  progress.end();
  f.ranks = f.machine ? described_rank_costs(*f.machine, o.ranks) : usual_rank_costs(o.ranks, cores);
  f.predictions = predict_all(f.costs, f.ranks, possible_layouts(o.ranks, true, f.machine ? 0 : cores));
  return f;
}

std::string to_text(const Forecast& f, int ranks) {
  return fmt::format("\na frame on {} ranks that share {} cores\n  {}: {}\n{}best: {}\n", ranks,
                     f.ranks.cores, f.machine ? f.machine->name : "measured here", describe(f.costs),
                     to_table(f.predictions), describe(f.predictions.front().layout));
}

nlohmann::json to_json(const Forecast& f) {
  nlohmann::json layouts = nlohmann::json::array();
  for (const Prediction& p : f.predictions)
    layouts.push_back({{"layout", describe(p.layout)},
                       {"gps", p.layout.gps},
                       {"renderers", p.layout.renderers},
                       {"idle", p.layout.idle},
                       {"roles", p.layout.placement == Placement::colocated ? "colocated" : "dedicated"},
                       {"mesh", {p.layout.mesh_columns, p.layout.mesh_rows}},
                       {"topology", p.layout.topology == Topology::mesh ? "mesh" : "ring"},
                       {"seconds", p.seconds},
                       {"gp_seconds", p.gp},
                       {"renderer_seconds", p.renderer},
                       {"core_seconds", p.shared},
                       {"token_seconds", p.tokens},
                       {"limit", name(p.limit)}});
  for (auto& layout : layouts)
    if (layout["topology"] == "ring") layout.erase("mesh");
  return {{"machine", f.machine ? nlohmann::json(f.machine->name) : nlohmann::json()},
          {"cores", f.ranks.cores},
          {"hop_seconds", f.ranks.hop},
          {"gp_seconds", f.costs.gp},
          {"gp_frame_seconds", f.costs.frame},
          {"renderer_seconds", f.costs.renderer()},
          {"region_seconds", f.costs.region},
          {"visible_voxels", f.costs.visible_voxels},
          {"splats", f.costs.splats},
          {"layouts", layouts}};
}

std::string list_of_series(const std::vector<std::string>& series) {
  std::string text = "\nseries in this folder (--series takes one)\n";
  for (const auto& one : series) text += fmt::format("  {}\n", one);
  return series.empty() ? std::string() : text;
}

std::string list_of_presets() {
  std::string text;
  for (const auto& preset : preset_names())
    text += fmt::format("{:<14}{}\n", preset.name, preset.description);
  return text;
}

nlohmann::json json_of_presets() {
  auto list = nlohmann::json::array();
  for (const auto& preset : preset_names())
    list.push_back({{"name", preset.name}, {"description", preset.description}});
  return list;
}

}  // namespace

ExitCode run_info(const InfoOptions& o) {
  if (o.presets) {
    fmt::print("{}", o.json ? plain_json_text(json_of_presets(), 2) + "\n" : list_of_presets());
    return ExitCode::done;
  }
  Progress progress;
  WatchedSource source(open_volume(o.volume), progress);
  const auto clip = clip_box(o.picture.clip, source.grid());
  const auto part = clipped_source(source, clip.value_or(whole_box(source.grid())));
  const Contents contents = read_contents(clip ? *part : source, progress);
  std::optional<Forecast> predicted;
  if (o.ranks > 0) predicted = forecast(o, source, progress);
  if (o.json) {
    auto j = to_json(o, source.grid(), part->grid(), contents, source.concurrent());
    if (predicted) j["prediction"] = to_json(*predicted);
    if (const auto series = source.notes().series; !series.empty()) j["series"] = series;
    fmt::print("{}\n", plain_json_text(std::move(j), 2));
  } else {
    fmt::print("{}{}{}", to_text(o, source.grid(), part->grid(), contents, source.concurrent()),
               predicted ? to_text(*predicted, o.ranks) : "", list_of_series(source.notes().series));
  }
  return ExitCode::done;
}

}  // namespace ringsplat::app

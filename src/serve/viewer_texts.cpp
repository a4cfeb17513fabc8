#include "serve/viewer.hpp"

#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat::serve {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Label, value, name)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunState::Parameter, name, value, low, high, choices)

namespace {

using nlohmann::json;

json histogram_json(const Histogram& histogram) {
  constexpr int shown_bins = 256;
  return {
      {"low", histogram.low}, {"high", histogram.high}, {"counts", coarser(histogram, shown_bins).counts}};
}

/// For each axis the lattice axes that point right and up in pictures of its slices: 1, 2 or 3, or where they
/// point the other way −1, −2 or −3.
json slices_json(const ShownVolume& volume) {
  json all = json::array();
  const LatticeFrame lattice = lattice_frame(volume.grid);
  for (const Axis axis : all_axes) {
    const ViewTransform view = make_view(facing_slices(lattice, axis, volume.patient), lattice, 1, 1);
    const auto code = [&](int screen, int way) {
      const auto [u, v] = in_plane(axis);
      const int k = std::abs(view.linear[u][screen]) > std::abs(view.linear[v][screen]) ? u : v;
      return way * view.linear[k][screen] < 0 ? -(k + 1) : k + 1;
    };
    all.push_back({{"right", code(0, 1)}, {"up", code(1, -1)}});
  }
  return all;
}

json volume_json(const ShownVolume& volume) {
  const auto& [dims, spacing, origin, axes, type] = volume.grid;
  const double* const direction = glm::value_ptr(axes);
  return {{"name", volume.name},
          {"dims", {dims.x, dims.y, dims.z}},
          {"spacing", {spacing.x, spacing.y, spacing.z}},
          {"origin", {origin.x, origin.y, origin.z}},
          {"unit", volume.unit},
          {"direction", std::vector(direction, direction + 9)},  // column by column
          {"patient", volume.patient},
          {"range", {volume.ranges.front().low, volume.ranges.front().high}},
          {"type", to_string(type)},
          {"slices", slices_json(volume)},
          {"labels", volume.labels},
          {"histogram", histogram_json(volume.histogram)}};
}

/// Those for Hounsfield units show nothing of other values.
json presets(const ShownVolume& volume) {
  json all = json::array();
  for (const auto& [name, description] : preset_names())
    if (volume.hounsfield || !name.starts_with("ct-")) all.push_back(to_json(preset(name, volume.histogram)));
  return all;
}

json channels_json(const ViewerOptions& o) {
  json all = json::array();
  for (std::size_t k = 0; k < o.channels.size(); ++k) {
    json windows = json::object();
    for (const auto& [mode, own] : o.channels[k].own) {
      const glm::dvec2 window = o.channels[k].window(mode);
      windows[name(mode)] = {window.x, window.y};
    }
    const ValueRange& range = o.volume.ranges[k];
    all.push_back({{"name", o.channels[k].name}, {"range", {range.low, range.high}}, {"windows", windows}});
  }
  return all;
}

/// `what`: a text "WHAT IS WRONG; hint: WHAT TO DO".
json said(const char* type, std::string_view what) {
  constexpr std::string_view between = "; hint: ";
  const auto at = what.find(between);
  return {{"type", type},
          {"message", what.substr(0, at)},
          {"hint", at == std::string_view::npos ? "" : what.substr(at + between.size())}};
}

}  // namespace

std::string hello_text(const ViewerOptions& o, const std::vector<Level>& levels, bool drives, int viewers) {
  json names = json::array();
  for (const Level& level : levels) names.push_back(level.name);
  json modes = json::object();
  for (const auto& [mode, function] : o.modes) modes[name(mode)] = to_json(function);
  return text_of({{"type", "hello"},
                  {"volume", volume_json(o.volume)},
                  {"frames", o.frames},
                  {"channels", channels_json(o)},
                  {"segments", o.segments},
                  {"state", to_json(o.initial)},
                  {"presets", presets(o.volume)},
                  {"modes", modes},
                  {"levels", names},
                  {"ranks", o.ranks},
                  {"layout", o.layout},
                  {"ffmpeg", o.ffmpeg.has_value()},
                  {"errors", bool(o.errors)},
                  {"largest", o.largest_side},
                  {"finer", o.finer},
                  {"part", o.part},
                  {"is_part", o.is_part},
                  {"driver", drives},
                  {"viewers", viewers}});
}

std::string frame_text(int frame, std::string_view status) {
  return text_of({{"type", "frame"}, {"frame", frame}, {"status", status}});
}

std::string run_text(const RunState& run) {
  return text_of({{"type", "run"},
                  {"step", run.step},
                  {"time", run.time},
                  {"rate", run.steps_a_second},
                  {"paused", run.paused},
                  {"histogram", histogram_json(run.histogram)},
                  {"parameters", run.parameters}});
}

std::string loading_text(double part) { return text_of({{"type", "loading"}, {"part", part}}); }

std::string error_text(std::string_view what, std::optional<std::uint32_t> id) {
  json error = said("error", what);
  if (id) error["id"] = *id;
  return text_of(error);
}

std::string warning_text(std::string_view what) { return text_of(said("warning", what)); }

}  // namespace ringsplat::serve

#include "study/calibration_cache.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/log.hpp"
#include "base/output_file.hpp"
#include "frame/frame_spec_bytes.hpp"

namespace ringsplat::app {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Size and time of the last change; for a folder only the time. Zeros when the path cannot be read.
json identity_of(const fs::path& path) {
  std::error_code ignored;
  const auto changed = fs::last_write_time(path, ignored).time_since_epoch().count();
  const auto bytes = fs::is_directory(path, ignored) ? 0 : fs::file_size(path, ignored);
  return {{"path", fs::weakly_canonical(path, ignored).string()}, {"bytes", bytes}, {"changed", changed}};
}

/// Identifies a build by its version and the program's file, as one version may be built more than once.
json this_program() {
  json j = identity_of("/proc/self/exe");
  j.erase("path");
  j["version"] = RINGSPLAT_VERSION;
  return j;
}

json views_json(const FrameSpec& reference, const std::vector<Camera>& views) {
  json all = json::array();
  for (const Camera& camera : views) {
    FrameSpec frame = reference;
    frame.shown.camera = camera;
    all.push_back(json::parse(to_json_text(frame)).at("camera"));
  }
  return all;
}

json layout_json(const RunOptions& run, const Layout& layout) {
  return {{"gps", layout.gps},
          {"renderers", layout.renderers},
          {"colocated", layout.placement == Placement::colocated},
          {"bundle", layout.bundle},
          {"mesh", {layout.mesh_columns, layout.mesh_rows, layout.routed()}},
          {"slots", run.protocol.slots},
          {"link_slots", run.protocol.link_slots},
          {"look_ahead", run.protocol.look_ahead},
          {"send_ahead", run.protocol.send_ahead},
          {"threads_per_rank", run.engine.threads_per_rank}};
}

json to_json(const MeasuredShortcuts& m) {
  return {{"setting", to_text(m.shortcuts)},
          {"seconds", m.seconds},
          {"rmse", m.rmse},
          {"rmse_high", m.rmse_high}};
}

/// Throws json::exception or std::domain_error when `rows` is no calibration.
std::vector<MeasuredShortcuts> measurements(const json& rows, const std::vector<Shortcuts>& settings) {
  if (rows.size() != settings.size()) throw std::domain_error("it has not one measurement for each setting");
  std::vector<MeasuredShortcuts> all;
  for (std::size_t k = 0; k < settings.size(); ++k) {
    const json& row = rows.at(k);
    const MeasuredShortcuts m{settings[k], row.at("seconds").get<double>(), row.at("rmse").get<double>(),
                              row.at("rmse_high").get<double>()};
    if (row.at("setting") != to_text(settings[k])) throw std::domain_error("its settings are others");
    if (!(m.seconds > 0 && m.rmse >= 0 && m.rmse_high >= m.rmse))
      throw std::domain_error("a measurement in it is impossible");
    all.push_back(m);
  }
  return all;
}

}  // namespace

std::string calibration_key(const RenderOptions& o, const FrameSpec& reference, const Layout& layout,
                            const Histogram& histogram, const std::vector<Camera>& views) {
  json frame = json::parse(to_json_text(reference));
  frame.erase("camera");
  frame.erase("frame");
  const std::string counts = json(histogram.counts).dump();
  return json{{"program", this_program()},
              {"volume", identity_of(o.volume.path)},
              {"values", {histogram.low, histogram.high, std::hash<std::string>{}(counts)}},
              {"frame", frame},
              {"views", views_json(reference, views)},
              {"fixed",
               {o.budget.fixed_opaque_threshold, o.budget.fixed_precision, o.budget.fixed_radius,
                o.budget.fixed_image_plane, o.budget.fixed_undersample, o.budget.fixed_slabs,
                o.budget.fixed_light_points, o.budget.other_engine.has_value()}},
              {"truth", to_string(o.error.truth.value_or(TruthKind::method))},
              {"layout", layout_json(o.run, layout)},
              {"pixels", o.error.pixels},
              {"seed", o.error.seed}}
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

std::optional<fs::path> cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && fs::path(cache).is_absolute()) return fs::path(cache) / "ringsplat";
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home != '\0') return fs::path(home) / ".cache" / "ringsplat";
  return std::nullopt;
}

fs::path calibration_file(const fs::path& folder, const std::string& key) {
  return folder / fmt::format("calibration-{:016x}.json", std::hash<std::string>{}(key));
}

std::optional<std::vector<MeasuredShortcuts>> read_calibration(const fs::path& file, const std::string& key,
                                                               const std::vector<Shortcuts>& settings) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  std::string problem;
  try {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const json stored = json::parse(text);
    if (stored.at("key") == json::parse(key)) return measurements(stored.at("measured"), settings);
    problem = "it was made for something else";
  } catch (const std::exception& e) {
    problem = e.what();
  }
  log_warning("the calibration {} cannot be used and is made again: {}", file.string(), problem);
  return std::nullopt;
}

void write_calibration(const fs::path& file, const std::string& key,
                       const std::vector<MeasuredShortcuts>& measured) {
  json rows = json::array();
  for (const auto& m : measured) rows.push_back(to_json(m));
  try {
    fs::create_directories(file.parent_path());
    write_text(file, json{{"key", json::parse(key)}, {"measured", rows}}.dump(1) + "\n");
  } catch (const std::exception& e) {
    log_warning("the calibration cannot be kept for the next run: {}; hint: XDG_CACHE_HOME says where",
                e.what());
  }
}

}  // namespace ringsplat::app

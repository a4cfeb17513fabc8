#include "study/calibration_cache.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "frame/frame_spec_bytes.hpp"
#include "program/kept_measurements.hpp"

namespace ringsplat::app {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

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

std::optional<std::vector<MeasuredShortcuts>> read_calibration(const fs::path& file, const std::string& key,
                                                               const std::vector<Shortcuts>& settings) {
  std::optional<std::vector<MeasuredShortcuts>> measured;
  read_kept(file, calibration_kind, key, [&](const json& rows) { measured = measurements(rows, settings); });
  return measured;
}

void write_calibration(const fs::path& file, const std::string& key,
                       const std::vector<MeasuredShortcuts>& measured) {
  json rows = json::array();
  for (const auto& m : measured) rows.push_back(to_json(m));
  write_kept(file, calibration_kind, key, rows);
}

}  // namespace ringsplat::app

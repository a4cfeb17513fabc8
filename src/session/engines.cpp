#include "session/engines.hpp"

#include <cmath>
#include <map>
#include <string>

#include "frame/frame_spec_bytes.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "splat_engine/splat_engine.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

struct EngineRow {
  const char* method;
  std::unique_ptr<Engine> (*make)(const EngineSetup& setup);
};
constexpr EngineRow engine_rows[] = {{Splats::name, make_splat_engine}, {Sheets::name, make_sheet_engine}};

std::unique_ptr<Engine> make_engine(const std::string& method, const EngineSetup& setup) {
  for (const EngineRow& row : engine_rows)
    if (method == row.method) return row.make(setup);
  throw RunError("there is no engine for " + method);
}

class Engines final : public Engine {
 public:
  explicit Engines(const EngineSetup& setup) : setup_(setup) {}

  FramePlan plan(const Announcement& a) override { return engine_of(a).plan(a); }
  std::unique_ptr<Encoder> encoder(int gp, const Announcement& a) override {
    return engine_of(a).encoder(gp, a);
  }
  Painter& painter(int renderer, const Announcement& a) override { return engine_of(a).painter(renderer, a); }
  std::unique_ptr<Canvas> canvas(const Announcement& a) override { return engine_of(a).canvas(a); }

 private:
  Engine& engine_of(const Announcement& a) {
    const std::string method = method_of(a.body);
    auto& engine = engines_[method];
    if (!engine) engine = make_engine(method, setup_);
    return *engine;
  }

  EngineSetup setup_;
  std::map<std::string, std::unique_ptr<Engine>> engines_;  ///< by method
};

}  // namespace

std::unique_ptr<Engine> make_engines(const EngineSetup& setup) { return std::make_unique<Engines>(setup); }

double payload_message_seconds(const Machine& m) {
  return sending_seconds(m, sizeof(Header)) + m.message.receive;
}

WorkCosts splat_costs(const Machine& m, double voxel_weight, int bundle) {
  return {voxel_weight * m.renderer.splat, m.renderer.composite,
          m.renderer.slice + payload_message_seconds(m) / bundle, voxel_weight * m.gp.visible_voxel,
          voxel_weight * m.gp.transparent_voxel};
}

WorkCosts sheet_costs(const Machine& m, double voxel_weight, int bundle) {
  constexpr double side = CellRanges::side;
  const double voxel = voxel_weight / (side * side);
  return {voxel * m.sheets.place,
          m.sheets.sample,
          m.sheets.slice + payload_message_seconds(m) / bundle,
          voxel * (m.sheets.copy + m.sheets.look),
          voxel * m.sheets.look,
          side / std::sqrt(voxel_weight)};
}

}  // namespace ringsplat

#include "session/engines.hpp"

#include <map>
#include <string>
#include <utility>

#include "frame/frame_spec_bytes.hpp"
#include "protocol/bundle_engine.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {
namespace {

class Engines final : public Engine {
 public:
  Engines(const EngineSetup& setup, std::vector<MethodEngine> methods)
      : setup_(setup), methods_(std::move(methods)) {}

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
    if (!engine) engine = make(method);
    return *engine;
  }
  std::unique_ptr<Engine> make(const std::string& method) const {
    for (const MethodEngine& known : methods_)
      if (method == known.method) return known.make(setup_);
    throw RunError("there is no engine for " + method);
  }

  EngineSetup setup_;
  std::vector<MethodEngine> methods_;
  std::map<std::string, std::unique_ptr<Engine>> engines_;  ///< by method
};

}  // namespace

std::vector<MethodEngine> drawing_engines() {
  return {{Splats::name, make_splat_engine}, {Sheets::name, make_sheet_engine}};
}

std::unique_ptr<Engine> make_engines(const EngineSetup& setup, std::vector<MethodEngine> methods) {
  return std::make_unique<Engines>(setup, std::move(methods));
}

std::unique_ptr<Engine> make_rank_engine(const EngineSetup& setup) {
  auto engine = make_engines(setup);
  return setup.bundle > 1 ? make_bundle_engine(std::move(engine), setup.bundle) : std::move(engine);
}

}  // namespace ringsplat

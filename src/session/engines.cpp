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
  Engines(std::vector<EngineSetup> volumes, std::vector<MethodEngine> methods)
      : volumes_(std::move(volumes)), methods_(std::move(methods)) {}

  FramePlan plan(const Announcement& a) override { return engine_of(a).plan(a); }
  std::unique_ptr<Encoder> encoder(int gp, const Announcement& a) override {
    return engine_of(a).encoder(gp, a);
  }
  Painter& painter(int renderer, const Announcement& a) override { return engine_of(a).painter(renderer, a); }
  std::unique_ptr<Canvas> canvas(const Announcement& a) override { return engine_of(a).canvas(a); }

 private:
  Engine& engine_of(const Announcement& a) {
    const std::pair key(volume_of(a.body), method_of(a.body));
    auto& engine = engines_[key];
    if (!engine) engine = make(key.first, key.second);
    return *engine;
  }
  std::unique_ptr<Engine> make(std::size_t volume, const std::string& method) const {
    for (const MethodEngine& known : methods_)
      if (method == known.method && volume < volumes_.size()) return known.make(volumes_[volume]);
    throw RunError("there is no engine for " + method);
  }

  std::vector<EngineSetup> volumes_;
  std::vector<MethodEngine> methods_;
  std::map<std::pair<std::size_t, std::string>, std::unique_ptr<Engine>> engines_;
};

}  // namespace

std::vector<MethodEngine> drawing_engines() {
  return {{Splats::name, make_splat_engine}, {Sheets::name, make_sheet_engine}};
}

std::unique_ptr<Engine> make_engines(const EngineSetup& setup, std::vector<MethodEngine> methods) {
  return std::make_unique<Engines>(std::vector{setup}, std::move(methods));
}

std::unique_ptr<Engine> make_rank_engine(const EngineSetup& setup, std::vector<EngineSetup> others) {
  others.insert(others.begin(), setup);
  std::unique_ptr<Engine> engine = std::make_unique<Engines>(std::move(others), drawing_engines());
  return setup.bundle > 1 ? make_bundle_engine(std::move(engine), setup.bundle) : std::move(engine);
}

}  // namespace ringsplat

#include "session/engines.hpp"

#include <map>
#include <string>
#include <utility>

#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {
namespace {

struct EngineRow {
  const char* method;
  std::unique_ptr<Engine> (*make)(const EngineSetup& setup);
};
constexpr EngineRow engine_rows[] = {{Splats::name, make_splat_engine}};

class Engines final : public Engine {
 public:
  Engines(SliceStore slices, const std::function<EngineSetup(const SliceStore&)>& make_setup)
      : slices_(std::move(slices)), setup_(make_setup(slices_)) {}

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
    for (const EngineRow& row : engine_rows)
      if (!engine && method == row.method) engine = row.make(setup_);
    if (!engine) throw RunError("there is no engine for " + method);
    return *engine;
  }

  SliceStore slices_;
  EngineSetup setup_;
  std::map<std::string, std::unique_ptr<Engine>> engines_;  ///< by method
};

}  // namespace

std::unique_ptr<Engine> make_engines(SliceStore slices,
                                     const std::function<EngineSetup(const SliceStore& slices)>& make_setup) {
  return std::make_unique<Engines>(std::move(slices), make_setup);
}

}  // namespace ringsplat

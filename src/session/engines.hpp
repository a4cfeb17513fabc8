#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// The engine of one method.
struct MethodEngine {
  const char* method;
  std::function<std::unique_ptr<Engine>(const EngineSetup& setup)> make;
};
/// Those that draw.
std::vector<MethodEngine> drawing_engines();

/// The engines of one rank. A frame's engine is found by the name of its method and made on first use.
std::unique_ptr<Engine> make_engines(const EngineSetup& setup,
                                     std::vector<MethodEngine> methods = drawing_engines());

/// The same, whose steps are the setup's bundles. Frames may be of the other volumes, too.
std::unique_ptr<Engine> make_rank_engine(const EngineSetup& setup, std::vector<EngineSetup> others = {});

}  // namespace ringsplat

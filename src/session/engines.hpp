#pragma once
#include <memory>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// The engines of one rank. A frame's engine is found by the name of its method and made on first use.
std::unique_ptr<Engine> make_engines(const EngineSetup& setup);

}  // namespace ringsplat

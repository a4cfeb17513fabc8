#pragma once
#include <functional>
#include <memory>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// The engines of one rank. Each frame's is found by the name of its method, and made when a frame first asks
/// for it. `slices` are the rank's own; make_setup(slices) is called once and says what all engines are made
/// for.
std::unique_ptr<Engine> make_engines(SliceStore slices,
                                     const std::function<EngineSetup(const SliceStore& slices)>& make_setup);

}  // namespace ringsplat

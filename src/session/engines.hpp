#pragma once
#include <functional>
#include <memory>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// The engines of one rank. A frame's engine is found by the name of its method and made on first use.
/// `slices` are the rank's own; make_setup(slices) is called once for all engines.
std::unique_ptr<Engine> make_engines(SliceStore slices,
                                     const std::function<EngineSetup(const SliceStore& slices)>& make_setup);

}  // namespace ringsplat

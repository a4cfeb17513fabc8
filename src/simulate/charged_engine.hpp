#pragma once
#include <memory>

#include "model/machine.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// An engine whose work takes as long on the simulated clock as `machine` says. A step is complete once its
/// time has passed. Time passes in pieces, so that the rank handles messages in between.
std::unique_ptr<Engine> make_charged_engine(std::unique_ptr<Engine> inner, const Machine& machine);

}  // namespace ringsplat

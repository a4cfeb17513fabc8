#pragma once
#include <memory>

#include "protocol/engine.hpp"
#include "ringsplat/model/machine.hpp"

namespace ringsplat {

/// An engine whose work takes as long on the simulated clock as `machine` says: a step is complete once the time for
/// it has passed, in pieces, so that a rank can look after messages in between.
std::unique_ptr<Engine> make_charged_engine(std::unique_ptr<Engine> inner, const Machine& machine);

}  // namespace ringsplat

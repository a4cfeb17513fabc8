#pragma once
#include <functional>
#include <memory>
#include <span>

#include "protocol/engine.hpp"
#include "simulate/machine.hpp"

namespace ringsplat {

/// How many slices a payload is of.
using SlicesOf = std::function<int(std::span<const std::byte> payload)>;

/// An engine whose work takes as long on the simulated clock as `machine` says. A step is complete once its
/// time has passed. Time passes in pieces, so that the rank handles messages in between.
std::unique_ptr<Engine> make_charged_engine(std::unique_ptr<Engine> inner, const Machine& machine,
                                            SlicesOf slices_of);

}  // namespace ringsplat

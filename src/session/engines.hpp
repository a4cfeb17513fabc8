#pragma once
#include <memory>

#include "frame/engine_setup.hpp"
#include "model/machine.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// The engines of one rank. A frame's engine is found by the name of its method and made on first use.
std::unique_ptr<Engine> make_engines(const EngineSetup& setup);

/// What work costs on a described machine, when each voxel stands for `voxel_weight` of its slice and slices
/// travel in bundles of `bundle`.
WorkCosts splat_costs(const Machine& machine, double voxel_weight, int bundle = 1);
WorkCosts sheet_costs(const Machine& machine, double voxel_weight, int bundle = 1);

/// A Renderer's software for a payload and its accept on a described machine.
double payload_message_seconds(const Machine& machine);

}  // namespace ringsplat

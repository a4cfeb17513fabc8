#include "simulate/simulation.hpp"

#include <utility>

#include "frame/engine_setup.hpp"
#include "net/lock_step_transport.hpp"
#include "protocol/bundle_engine.hpp"
#include "session/engines.hpp"
#include "simulate/charge.hpp"
#include "simulate/charged_engine.hpp"
#include "simulate/charged_transport.hpp"
#include "simulate/counting_engine.hpp"
#include "simulate/work_costs.hpp"

namespace ringsplat {
namespace {

int slices_of_bundle(std::span<const std::byte> payload) {
  int slices = 0;
  BundlePart part;
  for (std::size_t at = 0; at < payload.size() && take_part(payload, at, part); at += part.bytes) ++slices;
  return slices;
}

SlicesOf slices_of(const SimulationOptions& simulation, int bundle) {
  if (simulation.count_only) return slices_counted;
  if (bundle > 1) return slices_of_bundle;
  return [](std::span<const std::byte>) { return 1; };
}

std::unique_ptr<Engine> make_simulated_engine(const SimulationOptions& simulation, EngineSetup setup) {
  const auto& machine = simulation.machine;
  // A described machine's costs are those of looking at every voxel.
  setup.skip_empty = false;
  if (machine) {
    setup.splat_costs = splat_costs(*machine, simulation.voxel_weight, setup.bundle);
    setup.sheet_costs = sheet_costs(*machine, simulation.voxel_weight, setup.bundle);
  }
  auto engine =
      simulation.count_only ? make_counting_engine(setup, simulation.voxel_weight) : make_rank_engine(setup);
  return machine ? make_charged_engine(std::move(engine), *machine, slices_of(simulation, setup.bundle))
                 : std::move(engine);
}

}  // namespace

void simulate(const SimulationOptions& simulation, EngineOptions& options) {
  if (simulation.machine || simulation.count_only)
    options.engine = [simulation](EngineSetup setup) {
      return make_simulated_engine(simulation, std::move(setup));
    };
  if (simulation.machine)
    options.network = [machine = *simulation.machine, simulation](Transport& network) {
      return std::make_unique<ChargedTransport>(network, machine, simulation.count_only);
    };
  if (simulation.step_seconds > 0)
    options.pace = [seconds = simulation.step_seconds](Transport& links) {
      return std::make_unique<LockStepTransport>(links, std::make_shared<LockStep>(seconds, charge));
    };
}

}  // namespace ringsplat

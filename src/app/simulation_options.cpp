#include "app/simulation_options.hpp"

#include <limits>

#include "base/log.hpp"
#include "net/launcher.hpp"

namespace ringsplat::app {

void prepare_simulation(RunOptions& options, Launch& launch) {
  ProtocolOptions& protocol = options.protocol;
  SimulationOptions& simulation = options.simulation;
  launch.check_on_all_ranks([&] {
    if (!options.machine.empty()) simulation.machine = read_machine(options.machine);
    if (simulation.step_seconds > 0 && !simulated())
      throw InputError("--step-seconds needs the clock that simulated ranks have in common",
                       "start it with scripts/simulate.sh, or use --in-step in one process");
    if (simulated() && options.threads_per_rank.value_or(1) > 1)
      throw InputError(
          "--threads-per-rank has no meaning for simulated ranks, whose machine says what their work costs",
          "leave it out, and divide the costs in the machine's description by what threads would gain");
  });
  if (!simulated()) {
    if (simulation.machine && launch.rank() == 0)
      log_warning(
          "--machine has no effect here: only simulated ranks have a clock to charge (scripts/simulate.sh)");
    simulation.machine.reset();
  }
  simulate(simulation, options.engine);
  if (!simulated()) return;
  // Simulated time leaps while ranks wait; the simulator itself detects that no rank can go on.
  protocol.stall_timeout = std::numeric_limits<double>::infinity();
  if (simulation.step_seconds > 0) protocol.frames_in_flight = 1;
}

}  // namespace ringsplat::app

#include "simulate/simulation.hpp"

#include <utility>

#include "base/clock.hpp"
#include "frame/engine_setup.hpp"
#include "net/lock_step.hpp"
#include "net/transport.hpp"
#include "protocol/bundle_engine.hpp"
#include "session/engines.hpp"
#include "simulate/charge.hpp"
#include "simulate/counted_payload.hpp"
#include "simulate/machine.hpp"
#include "simulate/simulated_engines.hpp"
#include "simulate/work_costs.hpp"

namespace ringsplat {
namespace {

/// Charges the software costs of messages between ranks. The simulator adds the network's time itself.
class ChargedTransport final : public TransportDecorator {
 public:
  /// `transport` must outlive it. `count_only`: payloads only count.
  ChargedTransport(Transport& transport, const Machine& machine, bool count_only)
      : TransportDecorator(transport),
        machine_(machine),
        count_only_(count_only),
        shared_(shares_cores(machine, transport.ranks())) {}

  void send(int destination, Message message) override {
    Header& h = message.header;
    charge(sending_seconds(machine_, static_cast<double>(sizeof(Header) + h.bytes)));
    if (h.kind == Kind::token) charge(machine_.gp.token);
    if (h.kind == Kind::payload && count_only_) h.magic = counted_magic;
    inner_.send(destination, std::move(message));
  }
  std::optional<Message> receive() override {
    auto message = inner_.receive();
    if (message) charge(machine_.message.receive);
    return message;
  }
  /// A rank that waits has yielded its core, where others may compute.
  void wait_next() override {
    const double since = now_seconds();
    inner_.wait_next();
    if (shared_ && now_seconds() > since) sleep_simulated(machine_.message.wake);
  }
  void only_first_work(int ranks) override {
    shared_ = shares_cores(machine_, ranks);
    inner_.only_first_work(ranks);
  }

 private:
  Machine machine_;
  bool count_only_;
  bool shared_;  ///< more ranks work than there are cores
};

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

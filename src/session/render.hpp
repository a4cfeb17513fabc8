#pragma once
#include <optional>
#include <span>

#include "model/machine.hpp"
#include "net/collectives.hpp"
#include "net/loopback_options.hpp"
#include "net/transport.hpp"
#include "protocol/protocol_options.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// How a run's ranks talk: over a transport between processes, or, when `transport` is null, all in this
/// process over a loopback network.
struct Wiring {
  Collectives& collectives;
  Transport* transport = nullptr;
  LoopbackOptions loopback = {};
};

/// Options of runs that measure time or counts instead of making pictures (docs/simulation.md).
struct SimulationOptions {
  std::optional<Machine> machine;  ///< nodes charge its costs to the simulated clock
  bool count_only = false;  ///< payloads have their true size but carry only counts, and nothing is drawn
  double voxel_weight = 1;  ///< with count_only: voxels of a slice that each voxel stands for
  double step_seconds = 0;  ///< seconds a lock step of payloads and tokens; 0: no lock step
};

/// How a node does its work. No option changes a picture; count_only makes none.
struct EngineOptions {
  int threads_per_rank = 1;  ///< threads that share a node's work; they never call MPI
  SimulationOptions simulation = {};
};

/// Throws InputError that names the option when it asks for more threads than any machine has cores.
void check(const EngineOptions& options);

/// One image of a volume in memory, for programs that use Ringsplat as a library. `voxels` (grid.bytes()
/// bytes, native order) is read on process 0 only and is dealt to the GPs; the others may pass an empty span.
/// Every process passes the same grid, spec and layout. The image is returned on process 0; elsewhere it is
/// empty.
Image render_image(const Grid& grid, std::span<const std::byte> voxels, const FrameSpec& spec,
                   const Layout& layout, const Wiring& wiring, const ProtocolOptions& protocol = {},
                   const EngineOptions& engine = {});

}  // namespace ringsplat

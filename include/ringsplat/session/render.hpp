#pragma once
#include <optional>
#include <span>

#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/model/machine.hpp"
#include "ringsplat/net/collectives.hpp"
#include "ringsplat/net/layout.hpp"
#include "ringsplat/net/loopback_options.hpp"
#include "ringsplat/net/transport.hpp"
#include "ringsplat/protocol/protocol_options.hpp"

namespace ringsplat {

/// How a run's ranks talk: over a transport between processes, or, when `transport` is null, all in this
/// process over a loopback network.
struct Wiring {
  Collectives& collectives;
  Transport* transport = nullptr;
  LoopbackOptions loopback = {};
};

/// What is different when a run is about time or counts, not about pictures (docs/simulation.md).
struct SimulationOptions {
  std::optional<Machine> machine;  ///< whose costs the nodes charge to the simulated clock
  bool count_only = false;  ///< payloads have their true size but carry only counts, and nothing is drawn
  double voxel_weight = 1;  ///< with count_only: so many voxels of a slice for which each voxel stands
  double step_seconds = 0;  ///< above 0: payloads and tokens move in step, one step in so many seconds
};

/// How a node does its work; none of it changes a picture, but that count_only makes none.
struct EngineOptions {
  int threads_per_rank = 1;  ///< that share a node's work; they never call MPI
  SimulationOptions simulation = {};
};

/// Throws InputError naming the option when no machine has so many cores.
void check(const EngineOptions& options);

/// One image of a volume in memory, for programs that use Ringsplat as a library. `voxels` (grid.bytes()
/// bytes, native order) is read on process 0 only and is dealt to the GPs; the others may pass an empty span.
/// Every process passes the same grid, spec and layout. The image is returned on process 0; elsewhere it is
/// empty.
Image render_image(const Grid& grid, std::span<const std::byte> voxels, const FrameSpec& spec,
                   const Layout& layout, const Wiring& wiring, const ProtocolOptions& protocol = {},
                   const EngineOptions& engine = {});

}  // namespace ringsplat

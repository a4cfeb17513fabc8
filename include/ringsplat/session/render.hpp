#pragma once
#include <map>
#include <span>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "ringsplat/model/machine.hpp"
#include "ringsplat/net/loopback.hpp"
#include "ringsplat/session/director.hpp"
#include "ringsplat/scene/load.hpp"
#include "ringsplat/protocol/protocol_options.hpp"

namespace ringsplat {

/// A volume dealt to the GPs, ready to be rendered: what this process holds of it and what all know of it.
struct Scene {
  Grid grid;
  std::map<int, SliceStore> stores;  ///< by GP, those of this process
  ValueRange range;
  Histogram histogram;
};

/// How a run's ranks talk: over a transport between processes, or, when `transport` is null, all in this
/// process over a loopback network.
struct Wiring {
  Collectives& collectives;
  Transport* transport = nullptr;
  LoopbackOptions loopback = {};
};

/// Which slice sets a list of views traverses.
std::array<bool, 3> needed_axes(const std::vector<Camera>& cameras, const Grid& grid, int width, int height);

/// What has to be loaded for one frame.
LoadOptions load_options(const FrameSpec& spec, const Grid& grid);

/// Deals an opened volume's slices and gathers its range and histogram. All processes call it, with the same
/// grid, options and layout: all throw the same InputError that names a process which passed others.
Scene load_scene(OpenedVolume& volume, const LoadOptions& options, const Layout& layout,
                 const Wiring& wiring);

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

/// Renders the director's frames (asked for on process 0 only). All processes call it; returns when the last
/// frame is done. Throws InputError when the layout does not fit the number of processes, RunError when a run
/// fails.
void render_frames(Scene scene, const Layout& layout, const ProtocolOptions& protocol, Director director,
                   const Wiring& wiring, const EngineOptions& engine = {});

/// One image of a volume in memory, for programs that use Ringsplat as a library. `voxels` (grid.bytes()
/// bytes, native order) is read on process 0 only and is dealt to the GPs; the others may pass an empty span.
/// Every process passes the same grid, spec and layout. The image is returned on process 0; elsewhere it is
/// empty.
Image render_image(const Grid& grid, std::span<const std::byte> voxels, const FrameSpec& spec,
                   const Layout& layout, const Wiring& wiring, const ProtocolOptions& protocol = {},
                   const EngineOptions& engine = {});

}  // namespace ringsplat

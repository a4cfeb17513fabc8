#pragma once
#include <map>
#include <span>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "ringsplat/node/load.hpp"
#include "ringsplat/node/loopback_run.hpp"

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

/// Renders the director's frames (asked for on process 0 only). All processes call it; returns when the last
/// frame is done. Throws InputError when the layout does not fit the number of processes, RunError when a run
/// fails.
void render_frames(Scene scene, const Layout& layout, const ProtocolOptions& protocol, Director director,
                   const Wiring& wiring);

/// One image of a volume in memory, for programs that use Ringsplat as a library. `voxels` (grid.bytes()
/// bytes, native order) is read on process 0 only and is dealt to the GPs; the others may pass an empty span.
/// Every process passes the same grid, spec and layout. The image is returned on process 0; elsewhere it is
/// empty.
Image render_image(const Grid& grid, std::span<const std::byte> voxels, const FrameSpec& spec,
                   const Layout& layout, const Wiring& wiring, const ProtocolOptions& protocol = {});

}  // namespace ringsplat

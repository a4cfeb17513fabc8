#pragma once
#include <array>
#include <vector>

#include "scene/scene.hpp"
#include "session/director.hpp"
#include "session/render.hpp"

namespace ringsplat {

/// Which slice sets a list of views of the frame traverses, drawn by its method or by another one.
std::array<bool, 3> needed_axes(FrameSpec frame, const std::vector<Camera>& cameras, const Grid& grid,
                                const std::optional<Method>& or_by = std::nullopt);

/// What has to be loaded for one frame.
LoadOptions needed_to_render(const FrameSpec& spec, const Grid& grid);

/// Throws the InputError with which ranks would refuse to draw a frame of this volume. Costs no voxel.
void check_frame(const FrameSpec& spec, const Grid& grid);

Sharing sharing_of(const Layout& layout, const Wiring& wiring);

/// Throws InputError when the layout is none, or is for another number of ranks.
void check_wiring(const Layout& layout, const Wiring& wiring);

/// Throws InputError on all processes, with the name of one that differs, unless all mean the same scene and
/// run the same build. Collective.
void require_same_scene(const Grid& grid, const LoadOptions& options, const Layout& layout,
                        const Wiring& wiring);

/// Deals an opened volume's slices and gathers its range and histogram. All processes call it, with the same
/// grid, options and layout; otherwise all throw the same InputError that names a process that differs.
Scene load_scene(OpenedVolume& volume, const LoadOptions& options, const Layout& layout,
                 const Wiring& wiring);

/// Renders the director's frames of the scene and its others (asked for on process 0 only). All processes
/// call it; returns when the last frame is done. Throws InputError when the layout does not fit the number of
/// processes, RunError when a run fails.
void render_frames(Scene scene, const Layout& layout, const ProtocolOptions& protocol, Director director,
                   const Wiring& wiring, const EngineOptions& engine = {});

}  // namespace ringsplat

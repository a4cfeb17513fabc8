#pragma once
#include "app/render_job.hpp"
#include "serve/viewer.hpp"

namespace ringsplat::app {

/// What a viewer is told of the volume, which is shown as `first`, and of the job, which must outlive it.
serve::ViewerOptions viewer_options(const ServeOptions& options, const Job& job, const Scene& scene,
                                    const MadeFunction& made, const Shown& first, const Launch& launch);

/// Has a viewer, of this grid, go on where another one left off, from the same side.
void go_on_as(const serve::NextPart& part, const Grid& grid, serve::ViewerOptions& v);

/// Of all channels.
std::vector<ValueRange> ranges_of(const Scene& scene);

/// The grid of the finest level of what is shown.
const Grid& finest_of(const OpenedVolume& volume);

}  // namespace ringsplat::app

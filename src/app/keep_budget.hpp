#pragma once
#include <vector>

#include "app/launch.hpp"
#include "app/options.hpp"
#include "app/progress.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::app {

/// Changes `frame` (on rank 0, which announces frames) to the cheapest setting that keeps options.budget, by
/// the stored calibration or a new one. All processes call it; `cameras` are the run's, known on rank 0 only.
/// Returns true when it rendered with `scene`, which is then used up and must be loaded again. All throw the
/// same InputError when no setting keeps the budget.
bool keep_budget(const RenderOptions& options, const std::vector<Camera>& cameras,
                 const std::array<bool, 3>& kept_axes, const Layout& layout, Scene& scene, FrameSpec& frame,
                 Progress& progress, Launch& launch);

}  // namespace ringsplat::app

#pragma once
#include <functional>
#include <string>
#include <vector>

#include "app/render_job.hpp"

namespace ringsplat::app {

/// Changes `frame` (on rank 0, which announces frames) to the cheapest setting that keeps the job's budget,
/// by the stored calibration or a new one. All processes call it. Returns true when it rendered with `scene`,
/// which is then used up and must be loaded again. All throw the same InputError when no setting keeps the
/// budget.
bool keep_budget(Job& job, Scene& scene, FrameSpec& frame, Progress& progress, Launch& launch);

/// The pictures of a run, on rank 0.
struct Gallery {
  std::function<std::vector<Judged>()> judge;       ///< those that were not judged before
  std::function<void(FrameResult&&)> replace = {};  ///< the picture of the frame with this number
};

/// Draws pictures that break the budget again, with more exact settings, twice at most. All processes call
/// it, after keep_budget and the run. Warns of each picture that is over the budget then; returns whether
/// there is none.
bool hold_budget(Job& job, const Gallery& gallery, const Wiring& wiring, Progress& progress, Launch& launch);

}  // namespace ringsplat::app

#pragma once
#include "frame/frame_geometry.hpp"
#include "frame/work_estimate.hpp"

namespace ringsplat {

/// What work costs in a frame with such regions: a GP copies a block for all Renderers that see some of it.
WorkCosts costs_in(const FrameGeometry& geometry, WorkCosts costs);

/// Deals a frame's regions such that the busiest Renderer has the least work: the costliest first, each to
/// the Renderer with the least so far (Graham 1969, longest processing time first). Where no size of regions
/// is asked for, it tries several: smaller ones are dealt more evenly, larger ones cut less. Does nothing
/// when the estimate says little. `busy`: by Renderer that gets regions, seconds that its rank is busy
/// otherwise; empty: not at all. Every rank finds the same; no bit of the picture depends on it. Returns the
/// seconds of the busiest Renderer's rank, or 0 when nothing was dealt.
double deal_by_work(FrameGeometry& geometry, const WorkEstimate& work, const WorkCosts& costs,
                    const FrameSpec& spec, int renderers, const std::vector<double>& busy);

/// Seconds that Renderers' ranks are busy otherwise, for `busy` above, when `dealt_to` of the Renderers get
/// regions: with their GPs' slices, and the first with the picture, too.
std::vector<double> busy_ranks(const FrameGeometry& geometry, const WorkEstimate& work,
                               const WorkCosts& costs, SliceDealing dealing, int renderers, int dealt_to);

}  // namespace ringsplat

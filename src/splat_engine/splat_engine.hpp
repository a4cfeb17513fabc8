#pragma once
#include <algorithm>
#include <memory>

#include "base/thread_team.hpp"
#include "engine_parts/frame_engine.hpp"
#include "frame/engine_setup.hpp"
#include "splat_engine/splat_frame.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// Share of a piece's `wall` seconds for one part of its work: its threads were busy for `busy` seconds in
/// sum, `part` of them on that part. So a node's seconds add up to wall-clock time with any number of
/// threads.
inline double wall_share(double wall, double part, double busy) {
  return busy > 0 ? wall * std::min(part / busy, 1.0) : 0.0;
}

class EmptySpace;

/// A GP's encoder for one frame. `store`, `empty_space` and `threads` must outlive it; `empty_space` is kept
/// from frame to frame, one for each level of the store. EngineSetup explains `skip_empty` and
/// `timed`. Payloads have the same bytes with any number of threads. Throws RunError when the slices that the
/// frame traverses were not loaded.
std::unique_ptr<Encoder> make_splat_encoder(std::shared_ptr<const SplatFrame> frame, int renderers,
                                            const SliceStore& store, EmptySpace& empty_space,
                                            ThreadTeam& threads, bool skip_empty = true, bool timed = false);

/// A Renderer's painter. `threads` must outlive it; the image has the same bits with any number of them.
std::unique_ptr<FramePainter<SplatFrame>> make_splat_painter(int renderer, int renderers,
                                                             ThreadTeam& threads);

/// The paper's engine for one rank.
std::unique_ptr<Engine> make_splat_engine(const EngineSetup& setup);

}  // namespace ringsplat

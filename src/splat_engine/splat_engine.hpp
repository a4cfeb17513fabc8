#pragma once
#include <memory>
#include <utility>

#include "base/thread_team.hpp"
#include "classify/empty_space.hpp"
#include "engine_parts/frame_engine.hpp"
#include "frame/engine_setup.hpp"
#include "splat/footprint.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// A frame of this method, of which `geometry` must be made; without a `dealer` regions are dealt in turn.
struct SplatFrame : SharedFrame {
  SplatFrame(const FrameSpec& spec, FrameGeometry its_geometry, SliceDealing dealing, int renderers,
             RegionDealer* dealer = nullptr)
      : SharedFrame(spec, std::move(its_geometry), dealing, renderers, dealer),
        splats(spec.as<Splats>()),
        footprint(make_footprint(geometry.view, geometry.traversal.axis, splats.kernel_radius)) {}

  Splats splats;
  Footprint footprint;
};

/// A GP's encoder for one frame. `store`, `empty_space` and `threads` must outlive it; `empty_space` is kept
/// from frame to frame, one for each level of the store. EngineSetup explains `skip_empty`. Payloads have the
/// same bytes with any number of threads. Throws RunError when the slices that the frame traverses were not
/// loaded.
std::unique_ptr<Encoder> make_splat_encoder(std::shared_ptr<const SplatFrame> frame, int renderers,
                                            const SliceStore& store, EmptySpace& empty_space,
                                            ThreadTeam& threads, bool skip_empty = true);

/// A Renderer's painter. `threads` must outlive it; the image has the same bits with any number of them.
std::unique_ptr<FramePainter<SplatFrame>> make_splat_painter(int renderer, ThreadTeam& threads);

/// The paper's engine for one rank.
class SplatEngine : public FrameEngine<SplatFrame, EmptySpace> {
 public:
  explicit SplatEngine(const EngineSetup& setup)
      : FrameEngine(setup), encoder_threads_(setup.threads), painter_threads_(setup.threads) {}

 protected:
  std::shared_ptr<const SplatFrame> make_frame(const std::vector<FrameOfVolume>& frames) override {
    const auto& [volume, spec] = frames.front();
    if (frames.size() > 1) throw RunError("splats of several volumes are not drawn as one");
    auto frame = std::make_shared<SplatFrame>(spec, make_geometry(spec, setup_.grid), setup_.dealing(),
                                              setup_.renderers, &dealers_[volume]);
    frame->volume = volume;
    return frame;
  }
  std::unique_ptr<Encoder> make_encoder(std::shared_ptr<const SplatFrame> frame, EmptySpace& space) override {
    const SliceStore& slices = slices_of(*frame);
    return make_splat_encoder(std::move(frame), setup_.renderers, slices, space, encoder_threads_,
                              setup_.skip_empty);
  }
  std::unique_ptr<FramePainter<SplatFrame>> make_painter(int renderer) override {
    return make_splat_painter(renderer, painter_threads_);
  }

 private:
  ThreadTeam encoder_threads_, painter_threads_;
};

}  // namespace ringsplat

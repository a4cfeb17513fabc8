#include "splat_engine/splat_engine.hpp"

#include <utility>

#include "classify/empty_space.hpp"

namespace ringsplat {

std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, FrameGeometry geometry,
                                             SliceDealing dealing, int renderers, RegionDealer* dealer) {
  auto frame = std::make_shared<SplatFrame>();
  frame->number = spec.frame;
  frame->shown = spec.shown;
  frame->splats = spec.as<Splats>();
  frame->geometry = std::move(geometry);
  if (dealer != nullptr) dealer->deal(spec, frame->geometry);
  frame->footprint =
      make_footprint(frame->geometry.view, frame->geometry.traversal.axis, frame->splats.kernel_radius);
  frame->drawers = frame->geometry.owners(renderers);
  frame->plan = plan_of(frame->geometry, dealing, frame->drawers);
  return frame;
}

namespace {

class SplatParts {
 public:
  using Frame = SplatFrame;
  using Kept = EmptySpace;
  explicit SplatParts(const EngineSetup& setup)
      : setup_(setup), dealer_(setup), encoder_threads_(setup.threads), painter_threads_(setup.threads) {}

  std::shared_ptr<const SplatFrame> frame(const FrameSpec& spec) {
    return make_splat_frame(spec, make_geometry(spec, setup_.grid), setup_.dealing(), setup_.renderers,
                            &dealer_);
  }
  std::unique_ptr<Encoder> encoder(std::shared_ptr<const SplatFrame> frame, EmptySpace& space) {
    return make_splat_encoder(std::move(frame), setup_.renderers, *setup_.slices, space, encoder_threads_,
                              setup_.skip_empty);
  }
  std::unique_ptr<FramePainter<SplatFrame>> painter(int renderer) {
    return make_splat_painter(renderer, painter_threads_);
  }

 private:
  EngineSetup setup_;
  RegionDealer dealer_;
  ThreadTeam encoder_threads_, painter_threads_;
};

}  // namespace

std::unique_ptr<Engine> make_splat_engine(const EngineSetup& setup) {
  return std::make_unique<FrameEngine<SplatParts>>(setup);
}

}  // namespace ringsplat

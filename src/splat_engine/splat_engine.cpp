#include "splat_engine/splat_engine.hpp"

#include <map>
#include <utility>

#include "classify/empty_space.hpp"
#include "engine_parts/announced_frames.hpp"
#include "engine_parts/picture_canvas.hpp"

namespace ringsplat {
namespace {

class SplatEngine final : public Engine {
 public:
  explicit SplatEngine(const EngineSetup& setup)
      : setup_(setup), encoder_threads_(setup.threads), painter_threads_(setup.threads) {}

  FramePlan plan(const Announcement& a) override { return frame(a)->plan; }

  std::unique_ptr<Encoder> encoder(int, const Announcement& a) override {
    auto its = frame(a);
    auto& space = empty_space_[its->shown.reduction.factor];
    if (!space) space = std::make_unique<EmptySpace>();
    return make_splat_encoder(std::move(its), setup_.renderers, *setup_.slices, *space, encoder_threads_,
                              setup_.skip_empty, setup_.timed);
  }

  Painter& painter(int renderer, const Announcement& a) override {
    auto& painter = painters_[renderer];
    if (!painter) painter = make_splat_painter(renderer, setup_.renderers, painter_threads_);
    painter->begin_frame(frame(a));
    return *painter;
  }

  std::unique_ptr<Canvas> canvas(const Announcement& a) override {
    const auto its = frame(a);
    return make_picture_canvas(its->number, its->shown, {its, &its->geometry}, setup_.take);
  }

 private:
  std::shared_ptr<const SplatFrame> frame(const Announcement& a) {
    return frames_.get(a, [this](const FrameSpec& spec) {
      return make_splat_frame(spec, setup_.grid, setup_.gps, setup_.renderers);
    });
  }

  EngineSetup setup_;
  ThreadTeam encoder_threads_, painter_threads_;
  AnnouncedFrames<SplatFrame> frames_;
  std::map<int, std::unique_ptr<EmptySpace>> empty_space_;  ///< by level
  std::map<int, std::unique_ptr<FramePainter>> painters_;   ///< by Renderer
};

}  // namespace

std::unique_ptr<Engine> make_splat_engine(const EngineSetup& setup) {
  return std::make_unique<SplatEngine>(setup);
}

}  // namespace ringsplat

#include "sheet_engine/sheet_engine.hpp"

#include <map>
#include <utility>

#include "engine_parts/announced_frames.hpp"
#include "engine_parts/picture_canvas.hpp"
#include "sheet_engine/slice_blocks.hpp"

namespace ringsplat {
namespace {

class SheetEngine final : public Engine {
 public:
  explicit SheetEngine(const EngineSetup& setup) : setup_(setup), threads_(setup.threads) {}

  FramePlan plan(const Announcement& a) override { return frame(a)->plan; }

  std::unique_ptr<Encoder> encoder(int, const Announcement& a) override {
    auto its = frame(a);
    auto& blocks = blocks_[its->shown.reduction.factor];
    if (!blocks) blocks = std::make_unique<SliceBlocks>();
    return make_sheet_encoder(std::move(its), setup_.renderers, *setup_.slices, *blocks, setup_.skip_empty);
  }

  Painter& painter(int renderer, const Announcement& a) override {
    auto& painter = painters_[renderer];
    if (!painter) painter = make_sheet_painter(renderer, setup_.renderers, threads_);
    painter->begin_frame(frame(a));
    return *painter;
  }

  std::unique_ptr<Canvas> canvas(const Announcement& a) override {
    const auto its = frame(a);
    return make_picture_canvas(its->number, its->shown, {its, &its->geometry}, setup_.take);
  }

 private:
  std::shared_ptr<const SheetFrame> frame(const Announcement& a) {
    return frames_.get(a, [this](const FrameSpec& spec) {
      return make_sheet_frame(spec, setup_.grid, setup_.gps, setup_.renderers);
    });
  }

  EngineSetup setup_;
  ThreadTeam threads_;
  AnnouncedFrames<SheetFrame> frames_;
  std::map<int, std::unique_ptr<SliceBlocks>> blocks_;     ///< by level
  std::map<int, std::unique_ptr<SheetPainter>> painters_;  ///< by Renderer
};

}  // namespace

std::unique_ptr<Engine> make_sheet_engine(const EngineSetup& setup) {
  return std::make_unique<SheetEngine>(setup);
}

}  // namespace ringsplat

#pragma once
#include <map>
#include <memory>
#include <utility>

#include "engine_parts/announced_frames.hpp"
#include "engine_parts/picture_canvas.hpp"
#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// A Renderer's painter, which keeps its buffers from frame to frame.
template <class Frame>
class FramePainter : public Painter {
 public:
  /// Clears the image.
  virtual void begin_frame(std::shared_ptr<const Frame> frame) = 0;
};

/// One rank's engine of one method. `Parts`, made of the EngineSetup and what else it needs, has
///   Frame   the announced frame as the rank's nodes share it: number, shown, geometry, plan,
///   Kept    what a GP keeps from frame to frame, one for each level of its store,
/// and frame(spec), encoder(frame, kept) and painter(renderer).
template <class Parts>
class FrameEngine final : public Engine {
 public:
  template <class... More>
  explicit FrameEngine(const EngineSetup& setup, const More&... more)
      : parts_(setup, more...), take_(setup.take) {}

  FramePlan plan(const Announcement& a) override { return frame(a)->plan; }

  std::unique_ptr<Encoder> encoder(int, const Announcement& a) override {
    auto its = frame(a);
    auto& kept = kept_[its->shown.reduction.factor];
    if (!kept) kept = std::make_unique<Kept>();
    return parts_.encoder(std::move(its), *kept);
  }

  Painter& painter(int renderer, const Announcement& a) override {
    auto& painter = painters_[renderer];
    if (!painter) painter = parts_.painter(renderer);
    painter->begin_frame(frame(a));
    return *painter;
  }

  std::unique_ptr<Canvas> canvas(const Announcement& a) override {
    const auto its = frame(a);
    return make_picture_canvas(its->number, its->shown, {its, &its->geometry}, take_);
  }

 private:
  using Frame = typename Parts::Frame;
  using Kept = typename Parts::Kept;

  std::shared_ptr<const Frame> frame(const Announcement& a) {
    return frames_.get(a, [this](const FrameSpec& spec) { return parts_.frame(spec); });
  }

  Parts parts_;
  TakePicture take_;
  AnnouncedFrames<Frame> frames_;
  std::map<int, std::unique_ptr<Kept>> kept_;                     ///< by level
  std::map<int, std::unique_ptr<FramePainter<Frame>>> painters_;  ///< by Renderer
};

}  // namespace ringsplat

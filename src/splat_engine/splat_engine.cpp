#include "splat_engine/splat_engine.hpp"

#include <fmt/format.h>

#include <deque>
#include <map>
#include <utility>

#include "classify/empty_space.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// Throws RunError, not InputError: another rank made the announcement.
std::shared_ptr<const SplatFrame> announced_frame(const Announcement& a, const EngineSetup& setup) {
  const FrameSpec spec = decode_frame_spec(a.body);
  if (spec.frame != a.frame)
    throw RunError(fmt::format("rank 0 told of frame {} in a message about frame {}", spec.frame, a.frame));
  try {
    check(spec);
    return make_splat_frame(spec, setup.grid, setup.gps, setup.renderers);
  } catch (const InputError& e) {
    throw RunError(fmt::format("rank 0 told of a frame that cannot be: {}", e.what()));
  }
}

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
    return make_picture_canvas(frame(a), setup_.take);
  }

 private:
  /// The rank's nodes share the few frames in flight.
  std::shared_ptr<const SplatFrame> frame(const Announcement& a) {
    for (const auto& known : frames_)
      if (known->number == a.frame) return known;
    constexpr std::size_t most_remembered = 4;
    if (frames_.size() == most_remembered) frames_.pop_front();
    return frames_.emplace_back(announced_frame(a, setup_));
  }

  EngineSetup setup_;
  ThreadTeam encoder_threads_, painter_threads_;
  std::deque<std::shared_ptr<const SplatFrame>> frames_;
  std::map<int, std::unique_ptr<EmptySpace>> empty_space_;  ///< by level
  std::map<int, std::unique_ptr<FramePainter>> painters_;   ///< by Renderer
};

}  // namespace

std::unique_ptr<Engine> make_splat_engine(const EngineSetup& setup) {
  return std::make_unique<SplatEngine>(setup);
}

}  // namespace ringsplat

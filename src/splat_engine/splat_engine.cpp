#include "splat_engine/splat_engine.hpp"

#include <fmt/format.h>

#include <deque>
#include <map>
#include <utility>

#include "classify/empty_space.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

std::shared_ptr<const SplatFrame> make_splat_frame(const FrameSpec& spec, const Grid& grid, int gps,
                                                   int renderers) {
  auto frame = std::make_shared<SplatFrame>();
  frame->spec = spec;
  frame->geometry = make_geometry(spec, grid);
  const FrameGeometry& g = frame->geometry;
  FramePlan& plan = frame->plan;
  plan.ascending = g.traversal.ascending;
  plan.owners.resize(std::size_t(g.slices));
  for (int step = 0; step < g.slices; ++step)
    plan.owners[std::size_t(step)] = g.traversal.slice_at(step, g.slices) % gps;
  const RegionOwners owners = g.owners(renderers);
  plan.tiles.resize(std::size_t(g.regions.count()));
  for (int region = 0; region < g.regions.count(); ++region) {
    const PixelRect rect = g.regions.rect(region);
    plan.tiles[std::size_t(region)] = {
        owners.of(region), std::size_t(rect.width()) * std::size_t(rect.height()) * 4 * sizeof(float)};
  }
  return frame;
}

namespace {

/// Another rank made it: what cannot be is no bad input of this one.
FrameSpec announced_spec(const Announcement& a) {
  FrameSpec spec = decode_frame_spec(a.body);
  if (spec.frame != a.frame)
    throw RunError(fmt::format("rank 0 told of frame {} in a message about frame {}", spec.frame, a.frame));
  try {
    check(spec);
  } catch (const InputError& e) {
    throw RunError(fmt::format("rank 0 told of a frame that cannot be: {}", e.what()));
  }
  return spec;
}

class SplatEngine final : public Engine {
 public:
  SplatEngine(const Grid& grid, const Layout& layout, SliceStore slices, int threads, const EncoderOptions& options,
              TakePicture take)
      : grid_(grid),
        gps_(layout.gps),
        renderers_(layout.renderers),
        slices_(std::move(slices)),
        encoder_threads_(threads),
        painter_threads_(threads),
        options_(options),
        take_(std::move(take)) {}

  FramePlan plan(const Announcement& a) override { return frame(a)->plan; }

  std::unique_ptr<Encoder> encoder(int, const Announcement& a) override {
    auto its = frame(a);
    auto& space = empty_space_[its->spec.reduction.factor];
    if (!space) space = std::make_unique<EmptySpace>();
    return make_splat_encoder(std::move(its), renderers_, slices_, *space, encoder_threads_, options_);
  }

  Painter& painter(int renderer, const Announcement& a) override {
    auto& painter = painters_[renderer];
    if (!painter) painter = make_splat_painter(renderer, renderers_, painter_threads_);
    painter->begin_frame(frame(a));
    return *painter;
  }

  std::unique_ptr<Canvas> canvas(const Announcement& a) override { return make_picture_canvas(frame(a), take_); }

 private:
  /// The nodes of a rank ask for the same few frames.
  std::shared_ptr<const SplatFrame> frame(const Announcement& a) {
    for (const auto& known : frames_)
      if (known->spec.frame == a.frame) return known;
    FrameSpec spec = announced_spec(a);
    constexpr std::size_t most_remembered = 4;
    if (frames_.size() == most_remembered) frames_.pop_front();
    return frames_.emplace_back(make_splat_frame(std::move(spec), grid_, gps_, renderers_));
  }

  Grid grid_;
  int gps_, renderers_;
  SliceStore slices_;
  ThreadTeam encoder_threads_, painter_threads_;
  EncoderOptions options_;
  TakePicture take_;
  std::deque<std::shared_ptr<const SplatFrame>> frames_;
  std::map<int, std::unique_ptr<EmptySpace>> empty_space_;   ///< by level
  std::map<int, std::unique_ptr<FramePainter>> painters_;  ///< by Renderer
};

}  // namespace

std::unique_ptr<Engine> make_splat_engine(const Grid& grid, const Layout& layout, SliceStore slices, int threads,
                                          const EncoderOptions& options, TakePicture take) {
  return std::make_unique<SplatEngine>(grid, layout, std::move(slices), threads, options, std::move(take));
}

}  // namespace ringsplat

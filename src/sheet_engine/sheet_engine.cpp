#include "sheet_engine/sheet_engine.hpp"

#include <utility>

#include "sheet_engine/kept_blocks.hpp"
#include "sheet_engine/layers.hpp"
#include "sheet_engine/slice_blocks.hpp"

namespace ringsplat {

std::shared_ptr<const SheetFrame> make_sheet_frame(const FrameSpec& spec, const Grid& grid,
                                                   SliceDealing dealing, int renderers,
                                                   RegionDealer* dealer) {
  auto frame = std::make_shared<SheetFrame>();
  frame->number = spec.frame;
  frame->shown = spec.shown;
  frame->sheets = spec.as<Sheets>();
  frame->geometry = make_geometry(spec, grid);
  if (dealer != nullptr) dealer->deal(spec, frame->geometry);
  frame->transparent = transparent_values(spec.shown);
  const FrameGeometry& g = frame->geometry;
  frame->drawers = g.owners(renderers);
  const bool layers = g.layers.slices > 0;
  frame->plan = plan_of(g, dealing, layers ? g.tile_owners(renderers) : frame->drawers);
  if (layers) frame->plan.shares = shares_of_layers(*frame, renderers);
  return frame;
}

namespace {

class SheetParts {
 public:
  using Frame = SheetFrame;
  using Kept = SliceBlocks;
  explicit SheetParts(const EngineSetup& setup)
      : setup_(setup),
        dealer_(setup),
        threads_(setup.threads),
        kept_(setup.slices->gp(), setup.gps, setup.renderers, setup.kept_bytes) {}

  std::shared_ptr<const SheetFrame> frame(const FrameSpec& spec) {
    return make_sheet_frame(spec, setup_.grid, setup_.dealing(), setup_.renderers, &dealer_);
  }
  std::unique_ptr<Encoder> encoder(std::shared_ptr<const SheetFrame> frame, SliceBlocks& blocks) {
    return make_sheet_encoder(std::move(frame), setup_.renderers, *setup_.slices, blocks, setup_.skip_empty,
                              &kept_);
  }
  std::unique_ptr<FramePainter<SheetFrame>> painter(int renderer) {
    return make_sheet_painter(renderer, threads_);
  }

 private:
  EngineSetup setup_;
  RegionDealer dealer_;
  ThreadTeam threads_;
  KeptBlocks kept_;
};

}  // namespace

std::unique_ptr<Engine> make_sheet_engine(const EngineSetup& setup) {
  return std::make_unique<FrameEngine<SheetParts>>(setup);
}

}  // namespace ringsplat

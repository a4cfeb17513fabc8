#include "sheet_engine/sheet_engine.hpp"

#include <utility>

#include "sheet_engine/layers.hpp"

namespace ringsplat {

std::shared_ptr<const SheetFrame> make_sheet_frame(const FrameSpec& spec, const Grid& grid,
                                                   SliceDealing dealing, int renderers,
                                                   RegionDealer* dealer) {
  auto frame = std::make_shared<SheetFrame>(spec, make_geometry(spec, grid), dealing, renderers, dealer);
  frame->sheets = spec.as<Sheets>();
  frame->transparent = transparent_values(spec.shown);
  if (frame->geometry.layers.slices > 0) frame->plan.shares = shares_of_layers(*frame, renderers);
  return frame;
}

}  // namespace ringsplat

#include "sheet_engine/sheet_frame.hpp"

#include "engine_parts/frame_engine.hpp"

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
  frame->plan = plan_of(frame->geometry, dealing, renderers);
  return frame;
}

}  // namespace ringsplat

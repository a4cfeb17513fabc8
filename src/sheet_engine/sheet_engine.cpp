#include "sheet_engine/sheet_engine.hpp"

#include "sheet_engine/layers.hpp"

namespace ringsplat {

std::shared_ptr<const SheetFrame> make_sheet_frame(const FrameSpec& spec, const Grid& grid,
                                                   SliceDealing dealing, int renderers,
                                                   RegionDealer* dealer) {
  auto frame = std::make_shared<SheetFrame>(spec, make_geometry(spec, grid), dealing, renderers, dealer);
  frame->sheets = spec.as<Sheets>();
  frame->transparent = transparent_values(spec.shown, grid.type);
  if (frame->geometry.layers.slices > 0) frame->plan.shares = shares_of_layers(*frame, renderers);
  return frame;
}

std::shared_ptr<const SheetFrame> with_others(std::shared_ptr<const SheetFrame> first,
                                              const std::vector<FrameOfVolume>& frames) {
  if (frames.size() == 1 && frames.front().volume == first->volume) return first;
  const auto of = [&](const FrameOfVolume& one) {
    auto frame = std::make_shared<SheetFrame>(*first);
    frame->volume = one.volume;
    frame->shown = one.spec.shown;
    frame->transparent = transparent_values(one.spec.shown, first->geometry.grid.type);
    return frame;
  };
  const auto all = of(frames.front());
  if (frames.size() > 1 && !drawn_together(frames)) throw RunError("volumes that are not drawn as one");
  for (const FrameOfVolume& other : std::span(frames).subspan(1)) all->others.push_back(of(other));
  return all;
}

bool drawn_together(const std::vector<FrameOfVolume>& frames) {
  const FrameSpec& first = frames.front().spec;
  const Shown& shown = first.shown;
  const bool takes_one_value = shown.mode == Mode::mip || shown.mode == Mode::minip ||
                               shown.mode == Mode::mean || shown.mode == Mode::sum,
             mixes = shown.mode == Mode::composite && shown.mixed;
  if (!std::holds_alternative<Sheets>(first.how) || !(takes_one_value || mixes) || !shown.tints.empty() ||
      shown.values || frames.size() > most_channels)
    return false;
  return std::ranges::all_of(frames, [&](const FrameOfVolume& one) {
    FrameSpec same = one.spec;
    same.shown.transfer_function = shown.transfer_function;
    same.shown.isovalue = shown.isovalue;  // of surfaces
    same.shown.holes = shown.holes;
    if (mixes) same.shown.interpolation = shown.interpolation;
    return same == first;
  });
}

}  // namespace ringsplat

#include "splat_engine/splat_frame.hpp"

#include <utility>

#include "engine_parts/frame_plan.hpp"

namespace ringsplat {

std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, FrameGeometry geometry,
                                             SliceDealing dealing, int renderers, RegionDealer* dealer) {
  auto frame = std::make_shared<SplatFrame>();
  frame->number = spec.frame;
  frame->shown = spec.shown;
  frame->splats = spec.as<Splats>();
  frame->geometry = std::move(geometry);
  if (dealer != nullptr) dealer->deal(spec, frame->geometry);
  frame->footprint = make_footprint(frame->splats, frame->geometry);
  frame->plan = plan_of(frame->geometry, dealing, renderers);
  return frame;
}

std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, const Grid& grid, SliceDealing dealing,
                                             int renderers, RegionDealer* dealer) {
  return make_splat_frame(spec, make_geometry(spec, grid), dealing, renderers, dealer);
}

}  // namespace ringsplat

#include "splat_engine/splat_engine.hpp"

#include <utility>

namespace ringsplat {

std::shared_ptr<SplatFrame> make_splat_frame(const FrameSpec& spec, FrameGeometry geometry,
                                             SliceDealing dealing, int renderers, RegionDealer* dealer) {
  auto frame = std::make_shared<SplatFrame>(spec, std::move(geometry), dealing, renderers, dealer);
  frame->splats = spec.as<Splats>();
  frame->footprint =
      make_footprint(frame->geometry.view, frame->geometry.traversal.axis, frame->splats.kernel_radius);
  return frame;
}

}  // namespace ringsplat

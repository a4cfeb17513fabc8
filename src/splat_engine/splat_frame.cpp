#include "splat_engine/splat_frame.hpp"

#include "engine_parts/frame_plan.hpp"
#include "frame/region_choice.hpp"

namespace ringsplat {

std::shared_ptr<const SplatFrame> make_splat_frame(const FrameSpec& spec, const Grid& grid,
                                                   SliceDealing dealing, int renderers, RegionDealer* dealer,
                                                   double voxel_weight) {
  auto frame = std::make_shared<SplatFrame>();
  frame->number = spec.frame;
  frame->shown = spec.shown;
  frame->splats = spec.as<Splats>();
  frame->geometry = make_geometry(spec, grid);
  frame->voxel_weight = voxel_weight;
  if (voxel_weight > 1) {
    frame->geometry.reach = narrowed(frame->geometry.reach, voxel_weight);
    lay_regions(frame->geometry, spec.division, RegionForm::square);
  }
  if (dealer != nullptr) dealer->deal(spec, frame->geometry);
  frame->footprint = make_footprint(frame->splats, frame->geometry);
  if (voxel_weight > 1) frame->footprint.half = narrowed(frame->footprint.half, voxel_weight);
  frame->plan = plan_of(frame->geometry, dealing, renderers);
  return frame;
}

}  // namespace ringsplat

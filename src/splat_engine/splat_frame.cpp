#include "splat_engine/splat_frame.hpp"

#include "volume/slice_store.hpp"

namespace ringsplat {

std::shared_ptr<const SplatFrame> make_splat_frame(const FrameSpec& spec, const Grid& grid, int gps,
                                                   int renderers) {
  auto frame = std::make_shared<SplatFrame>();
  frame->number = spec.frame;
  frame->shown = spec.shown;
  frame->splats = spec.as<Splats>();
  frame->geometry = make_geometry(spec, grid);
  frame->footprint = make_footprint(frame->splats, frame->geometry);
  const FrameGeometry& g = frame->geometry;
  FramePlan& plan = frame->plan;
  plan.ascending = g.traversal.ascending;
  plan.owners.resize(std::size_t(g.slices));
  for (int step = 0; step < g.slices; ++step)
    plan.owners[std::size_t(step)] = SliceStore::owner_of(g.traversal.slice_at(step, g.slices), gps);
  const RegionOwners owners = g.owners(renderers);
  plan.tiles.resize(std::size_t(g.regions.count()));
  for (int region = 0; region < g.regions.count(); ++region) {
    const PixelRect rect = g.regions.rect(region);
    plan.tiles[std::size_t(region)] = {
        owners.of(region), std::size_t(rect.width()) * std::size_t(rect.height()) * 4 * sizeof(float)};
  }
  return frame;
}

}  // namespace ringsplat

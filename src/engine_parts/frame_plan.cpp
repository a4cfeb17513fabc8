#include "engine_parts/frame_plan.hpp"

#include <algorithm>

#include "volume/slice_store.hpp"

namespace ringsplat {

FramePlan plan_of(const FrameGeometry& g, int gps, int renderers) {
  FramePlan plan;
  plan.ascending = g.traversal.ascending;
  plan.owners.resize(std::size_t(g.slices));
  // Owners are those of the whole volume's slices.
  const int first = g.box.first[static_cast<int>(g.traversal.axis)];
  for (int step = 0; step < g.slices; ++step)
    plan.owners[std::size_t(step)] = SliceStore::owner_of(first + g.traversal.slice_at(step, g.slices), gps);
  const RegionOwners owners = g.owners(renderers);
  plan.tiles.resize(std::size_t(g.regions.count()));
  for (int region = 0; region < g.regions.count(); ++region) {
    const PixelRect rect = g.regions.rect(region);
    plan.tiles[std::size_t(region)] = {
        owners.of(region), std::size_t(rect.width()) * std::size_t(rect.height()) * 4 * sizeof(float)};
  }
  return plan;
}

void RegionDealer::deal(const FrameSpec& spec, FrameGeometry& g) {
  if (!setup_.sketch || setup_.renderers < 2) return;
  const int dealt_to = g.dealt_to > 0 ? std::min(g.dealt_to, setup_.renderers) : setup_.renderers;
  if (even_enough(g, dealt_to)) return;
  const bool sheets = std::holds_alternative<Sheets>(spec.how);
  const WorkCosts costs = costs_in(g, sheets ? setup_.sheet_costs : setup_.splat_costs);
  const WorkEstimate work(g, *setup_.sketch,
                          shown_.of(*setup_.sketch, spec.shown.transfer_function,
                                    sheets ? std::optional(g.traversal.axis) : std::nullopt),
                          costs, spec.shown.reduction.factor);
  std::vector<double> busy;
  if (setup_.colocated) busy = busy_gps(work, setup_.gps, setup_.renderers, dealt_to);
  deal_by_work(g, work, costs, spec.division, sheets ? RegionForm::flat : RegionForm::square,
               setup_.renderers, busy);
}

}  // namespace ringsplat

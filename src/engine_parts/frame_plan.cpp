#include "engine_parts/frame_plan.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace ringsplat {

FramePlan plan_of(const FrameGeometry& g, SliceDealing dealing, int renderers) {
  FramePlan plan;
  plan.ascending = g.traversal.ascending;
  plan.owners.resize(std::size_t(g.slices));
  // Owners are those of the whole volume's slices.
  const int first = g.box.first[static_cast<int>(g.traversal.axis)];
  plan.first_slice = first + g.traversal.slice_at(0, g.slices);
  for (int step = 0; step < g.slices; ++step)
    plan.owners[std::size_t(step)] = dealing.owner_of(first + g.traversal.slice_at(step, g.slices));
  const RegionOwners owners = g.owners(renderers);
  plan.tiles.resize(std::size_t(g.regions.count()));
  for (int region = 0; region < g.regions.count(); ++region) {
    const PixelRect rect = g.regions.rect(region);
    plan.tiles[std::size_t(region)] = {
        owners.of(region), std::size_t(rect.width()) * std::size_t(rect.height()) * 4 * sizeof(float)};
  }
  return plan;
}

namespace {

/// As many of the shown points as are needed to compare the parts of so many Renderers, and how many each
/// stands for. All ranks look at them before each frame, also those that share a core.
std::pair<std::vector<std::uint32_t>, int> enough(std::span<const std::uint32_t> shown, int renderers) {
  constexpr std::size_t for_each = 2000;
  // Odd, so that it goes across rows of an even number of points.
  const std::size_t step = shown.size() / (for_each * std::size_t(renderers)) | 1;
  std::vector<std::uint32_t> some;
  for (std::size_t k = 0; k < shown.size(); k += step) some.push_back(shown[k]);
  return {std::move(some), int(step)};
}

}  // namespace

void RegionDealer::deal(const FrameSpec& spec, FrameGeometry& g) {
  if (!setup_.sketch || setup_.renderers < 2) return;
  const int dealt_to = g.dealt_to > 0 ? std::min(g.dealt_to, setup_.renderers) : setup_.renderers;
  const bool sheets = std::holds_alternative<Sheets>(spec.how);
  // Dealt in turn, so many for each Renderer give none much more work than others; neighbouring strips cost
  // nearly the same.
  const int enough_each = sheets ? 8 : 16;
  if (!setup_.colocated && g.reached.width() * g.reached.height() >= enough_each * dealt_to) return;
  const WorkCosts costs = costs_in(g, sheets ? setup_.sheet_costs : setup_.splat_costs);
  const auto [points, stands_for] =
      enough(shown_.of(*setup_.sketch, spec.shown.transfer_function, shown_blocks(g, costs)), dealt_to);
  const WorkEstimate work(g, *setup_.sketch, points, costs, spec.shown.reduction.factor, -1, stands_for);
  std::vector<double> busy;
  if (setup_.colocated) busy = busy_ranks(g, work, costs, setup_.dealing(), setup_.renderers, dealt_to);
  deal_by_work(g, work, costs, spec, setup_.renderers, busy);
}

}  // namespace ringsplat

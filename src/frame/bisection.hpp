#pragma once
#include <span>
#include <vector>

#include "screen/regions.hpp"

namespace ringsplat {

/// A region that is to be dealt, and the seconds that it takes to draw.
struct RegionWork {
  int region = 0;
  double seconds = 0;
};

/// Deals neighbouring regions to each Renderer, whose shares are as `room`: recursive coordinate bisection
/// (Berger and Bokhari 1987). All are cut in two across their longer side, half of the Renderers get either
/// part, and so on. A cut may have a step of a region, so that parts are even where regions are few. Where
/// work moves a little, cuts move a little, so that most regions stay where they were. Returns owners by
/// region, indices of `room`; nobody owns regions that are not among the given ones.
std::vector<int> bisect(const Regions& regions, std::vector<RegionWork> work, std::span<const double> room);

}  // namespace ringsplat

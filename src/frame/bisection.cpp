#include "frame/bisection.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace ringsplat {
namespace {

double sum_of(std::span<const double> some) { return std::accumulate(some.begin(), some.end(), 0.0); }

/// Row by row, or column by column where all are clearly wider than high: a volume that is turned round an
/// upright axis stays in its rows.
void sort_along_longer_side(const Regions& regions, std::span<RegionWork> work) {
  PixelRect all = regions.rect(work.front().region);
  for (const RegionWork& one : work) {
    const PixelRect rect = regions.rect(one.region);
    all = {std::min(all.x0, rect.x0), std::min(all.y0, rect.y0), std::max(all.x1, rect.x1),
           std::max(all.y1, rect.y1)};
  }
  constexpr double clearly = 1.4;  // half-way between the shapes that halves of a square have
  const bool by_column = all.width() > clearly * all.height();
  const auto place = [&](const RegionWork& one) {
    return std::pair(by_column ? one.region % regions.columns() : 0, one.region);
  };
  std::ranges::sort(work, {}, place);
}

/// Among the Renderers from `first` on, as many as there is room for.
void deal(const Regions& regions, std::span<RegionWork> work, std::span<const double> room, int first,
          std::vector<int>& owner) {
  if (work.empty()) return;
  if (room.size() == 1) {
    for (const RegionWork& one : work) owner[std::size_t(one.region)] = first;
    return;
  }
  sort_along_longer_side(regions, work);
  const std::size_t half = room.size() / 2;
  const double all = sum_of(room), share = all > 0 ? sum_of(room.first(half)) / all : 0.5;
  double wanted = 0, sum = 0;
  for (const RegionWork& one : work) wanted += share * one.seconds;
  std::size_t cut = 0;
  while (cut < work.size() && sum + 0.5 * work[cut].seconds < wanted) sum += work[cut++].seconds;
  deal(regions, work.first(cut), room.first(half), first, owner);
  deal(regions, work.subspan(cut), room.subspan(half), first + int(half), owner);
}

}  // namespace

std::vector<int> bisect(const Regions& regions, std::vector<RegionWork> work, std::span<const double> room) {
  std::vector<int> owner(std::size_t(regions.count()), RegionOwners::nobody);
  deal(regions, work, room, 0, owner);
  return owner;
}

}  // namespace ringsplat

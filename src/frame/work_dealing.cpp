#include "frame/work_estimate.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>

namespace ringsplat {
namespace {

double sum_of(std::span<const double> some) { return std::accumulate(some.begin(), some.end(), 0.0); }

struct PlacedWork {
  std::array<int, 2> place;  ///< row, column
  int region;
  double seconds;
};

/// Row by row, or column by column where all are clearly wider than high: a volume that is turned round an
/// upright axis stays in its rows. They come in either order, so that a stable sort by one number does.
void sort_along_longer_side(const Regions& regions, std::span<PlacedWork> work) {
  std::array<int, 2> first = work.front().place, last = first;
  for (const PlacedWork& one : work)
    for (const std::size_t k : {0, 1}) {
      first[k] = std::min(first[k], one.place[k]);
      last[k] = std::max(last[k], one.place[k]);
    }
  const PixelRect corner = regions.rect(first[0] * regions.columns() + first[1]),
                  other = regions.rect(last[0] * regions.columns() + last[1]);
  constexpr double clearly = 1.4;  // half-way between the shapes that halves of a square have
  const std::size_t k = other.x1 - corner.x0 > clearly * (other.y1 - corner.y0) ? 1 : 0;
  const auto along = [k](const PlacedWork& one) { return one.place[k]; };
  if (!std::ranges::is_sorted(work, {}, along)) std::ranges::stable_sort(work, {}, along);
}

/// Among the Renderers from `first` on, as many as there is room for.
void deal_halves(const Regions& regions, std::span<PlacedWork> work, std::span<const double> room, int first,
                 std::vector<int>& owner) {
  if (work.empty()) return;
  if (room.size() == 1) {
    for (const PlacedWork& one : work) owner[std::size_t(one.region)] = first;
    return;
  }
  sort_along_longer_side(regions, work);
  const std::size_t half = room.size() / 2;
  const double all = sum_of(room), share = all > 0 ? sum_of(room.first(half)) / all : 0.5;
  double wanted = 0, sum = 0;
  for (const PlacedWork& one : work) wanted += share * one.seconds;
  std::size_t cut = 0;
  while (cut < work.size() && sum + 0.5 * work[cut].seconds < wanted) sum += work[cut++].seconds;
  deal_halves(regions, work.first(cut), room.first(half), first, owner);
  deal_halves(regions, work.subspan(cut), room.subspan(half), first + int(half), owner);
}

/// One way to cut the image plane, and who gets what.
struct Deal {
  Regions regions;
  PixelRect reached;
  std::vector<int> owner;  ///< by region, an index among those that get some
  double longest = 0;
};

struct Costly {
  int region;
  PartWork work;
  double seconds;  ///< payloads included
};

double seconds_of(std::uint64_t layers, double payload) { return payload * std::popcount(layers); }

/// Regions that voxels can reach, row by row. `payload`: seconds for the payloads of a layer.
std::vector<Costly> reached_work(const Regions& regions, const PixelRect& reached, const WorkEstimate& work,
                                 double payload) {
  std::vector<Costly> all;
  for (int y = reached.y0; y < reached.y1; ++y)
    for (int x = reached.x0; x < reached.x1; ++x) {
      const int region = y * regions.columns() + x;
      const PartWork part = work.of(regions.rect(region));
      all.push_back({region, part, part.seconds + seconds_of(part.layers, payload)});
    }
  return all;
}

/// A Renderer with regions in the same slices gets one payload of each for all of them.
void deal_out(Deal& deal, const std::vector<Costly>& costly, const WorkEstimate& work, double payload,
              const std::vector<double>& busy, const std::vector<double>& pace) {
  using Load = std::pair<double, int>;
  std::priority_queue<Load, std::vector<Load>, std::greater<>> least;
  for (std::size_t k = 0; k < busy.size(); ++k) least.emplace(busy[k], int(k));
  std::vector<std::uint64_t> layers(busy.size(), 0);
  std::vector<int> used;
  deal.owner.assign(std::size_t(deal.regions.count()), nobody);
  deal.longest = 0;
  std::size_t empty = 0;
  for (const Costly& one : costly) {
    int& owner = deal.owner[std::size_t(one.region)];
    // Where nothing is expected something may be, but nobody need draw for that alone.
    if (one.work.layers == 0 && !used.empty()) {
      owner = used[empty++ % used.size()];
      continue;
    }
    const auto [before, k] = least.top();
    least.pop();
    std::uint64_t& seen = layers[std::size_t(k)];
    if (seen == 0) used.push_back(k);
    const double begun = seen == 0 ? std::max(before, work.ready_seconds(one.work.layers)) : before,
                 seconds = one.work.seconds + seconds_of(one.work.layers & ~seen, payload),
                 load = begun + pace[std::size_t(k)] * seconds;
    seen |= one.work.layers;
    deal.longest = std::max(deal.longest, load);
    least.emplace(load, k);
    owner = k;
  }
}

/// Who gets which region, neighbouring ones to each: few blocks go to two Renderers then, and those that one
/// has kept stay useful while a view turns.
std::vector<int> side_by_side(const FrameGeometry& g, const WorkEstimate& work, double payload,
                              const std::vector<double>& busy, const std::vector<double>& pace) {
  const std::vector<Costly> reached = reached_work(g.regions, g.reached, work, payload);
  std::vector<RegionWork> regions;
  double all = 0;
  for (const Costly& one : reached) {
    // Where hardly anything is known of, all regions count alike.
    regions.push_back({one.region, work.telling() ? one.work.inside : 1});
    all += regions.back().seconds;
  }
  std::vector<int> owner;
  std::vector<double> spent = busy;
  // How many payloads one gets follows from what it is dealt.
  for (int pass = 0; pass < 2; ++pass) {
    double done = all, rate = 0;  // by a time at which all are done
    for (std::size_t k = 0; k < busy.size(); ++k) {
      done += spent[k] / pace[k];
      rate += 1 / pace[k];
    }
    std::vector<double> room;
    for (std::size_t k = 0; k < busy.size(); ++k)
      room.push_back(std::max(0.0, done / rate - spent[k]) / pace[k]);
    owner = bisect(g.regions, regions, room);
    std::vector<std::uint64_t> seen(busy.size(), 0);
    for (const Costly& one : reached) seen[std::size_t(owner[std::size_t(one.region)])] |= one.work.layers;
    for (std::size_t k = 0; k < busy.size(); ++k) spent[k] = busy[k] + pace[k] * seconds_of(seen[k], payload);
  }
  return owner;
}

/// The ways to cut the plane that are worth trying, from the coarsest; the first is what it is cut into now.
std::vector<Regions> ways_to_cut(const FrameGeometry& g, const FrameSpec& spec, std::size_t dealt_to) {
  std::vector<Regions> ways{g.regions};
  if (spec.division.region_size > 0 || g.warp) return ways;
  constexpr int enough_each = 24;
  const auto worth_trying = [&] { return std::size_t(ways.back().count()) < enough_each * dealt_to; };
  if (std::holds_alternative<Splats>(spec.how)) {
    ways.clear();
    for (const int side : {128, 64, 48, 32, 24, 16})
      if (ways.empty() || worth_trying()) ways.emplace_back(g.width, g.height, side);
  } else {
    const PixelRect first = g.regions.rect(0);
    for (const int width : {64, 32, 16})
      if (worth_trying() && width < first.width())
        ways.emplace_back(g.width, g.height, width, first.height());
  }
  return ways;
}

/// The costliest region first, each to the Renderer with the least so far; none where nothing is reached.
std::optional<Deal> costliest_first(const FrameGeometry& g, const WorkEstimate& work, double payload,
                                    const FrameSpec& spec, const std::vector<double>& busy,
                                    const std::vector<double>& pace) {
  constexpr double worth_smaller = 0.95;
  std::optional<Deal> best;
  for (const Regions& regions : ways_to_cut(g, spec, busy.size())) {
    Deal deal{regions, reached_regions(g, regions), {}};
    auto costly = reached_work(deal.regions, deal.reached, work, payload);
    if (costly.empty()) return std::nullopt;
    std::ranges::stable_sort(costly, std::ranges::greater{}, &Costly::seconds);
    if (best && costly.front().seconds >= worth_smaller * best->longest) continue;
    deal_out(deal, costly, work, payload, busy, pace);
    if (!best || deal.longest < worth_smaller * best->longest) best = std::move(deal);
  }
  return best;
}

}  // namespace

std::vector<int> bisect(const Regions& regions, const std::vector<RegionWork>& work,
                        std::span<const double> room) {
  std::vector<int> owner(std::size_t(regions.count()), nobody);
  std::vector<PlacedWork> placed;
  for (const auto& [region, seconds] : work)
    placed.push_back({{region / regions.columns(), region % regions.columns()}, region, seconds});
  deal_halves(regions, placed, room, 0, owner);
  return owner;
}

double copies_of_blocks(const FrameGeometry& g, double side) {
  const PixelRect region = g.regions.rect(0);
  glm::dvec2 size(region.width(), region.height());
  // A Renderer's part is about square.
  if (g.in_parts)
    size = glm::dvec2(
        std::sqrt(size.x * g.reached.width() * size.y * g.reached.height() / std::max(1, g.dealt_to)));
  const glm::dvec2 block = size_of_block(g, side);
  return (1 + block.x / size.x) * (1 + block.y / size.y);
}

WorkCosts costs_in(const FrameGeometry& g, WorkCosts costs) {
  if (costs.block > 0) costs.visible *= copies_of_blocks(g, costs.block);
  return costs;
}

void deal_by_work(FrameGeometry& g, const WorkEstimate& work, const WorkCosts& costs, const FrameSpec& spec,
                  int renderers, const std::vector<double>& busy) {
  if (busy.size() < 2 || (!g.in_parts && !work.telling())) return;
  const double payload = costs.payload * work.slices_of_layer();
  std::vector<double> pace(spec.division.pace.begin(), spec.division.pace.end());
  if (pace.size() != busy.size()) pace.assign(busy.size(), 1);
  if (g.in_parts) {
    g.dealt = side_by_side(g, work, payload, busy, pace);
  } else {
    const auto best = costliest_first(g, work, payload, spec, busy, pace);
    if (!best) return;
    g.regions = best->regions;
    g.reached = best->reached;
    g.dealt = best->owner;
  }
  for (int& owner : g.dealt)
    if (owner != nobody) owner = int(std::int64_t{owner} * renderers / std::int64_t(busy.size()));
}

std::vector<double> busy_ranks(const FrameGeometry& g, const WorkEstimate& work, const WorkCosts& costs,
                               SliceDealing dealing, int renderers, int dealt_to) {
  const std::vector<double> of_gp = work.gp_seconds(dealing);
  std::vector<double> busy;
  for (int k = 0; k < dealt_to; ++k) {
    const auto rank = std::size_t(std::int64_t{k} * renderers / dealt_to);
    busy.push_back(rank < of_gp.size() ? of_gp[rank] : 0);
  }
  busy.front() += costs.picture * g.width * g.height;
  return busy;
}

}  // namespace ringsplat

#include "forecast/role_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "net/mesh.hpp"
#include "screen/regions.hpp"

namespace ringsplat::app {
namespace {

std::vector<double> by_renderer(const FrameCosts& costs, int renderers) {
  const PixelRect all{0, 0, costs.columns, (int(costs.region.size()) - 1) / costs.columns + 1};
  const RegionOwners owners(costs.columns, all, renderers, renderers);
  std::vector<double> seconds(std::size_t(renderers), 0.0);
  for (std::size_t region = 0; region < costs.region.size(); ++region)
    seconds[std::size_t(owners.of(int(region)))] += costs.region[region];
  return seconds;
}

/// Seconds of GP `gp` for its slices: the largest share or one less.
double gp_seconds(const FrameCosts& costs, int gp, const Layout& layout) {
  const double bundles = std::ceil(costs.slices / layout.bundle),
               own = std::max(0.0, std::ceil((bundles - gp) / layout.gps)),
               slices = std::min(own * layout.bundle, std::ceil(costs.slices));
  return costs.frame + costs.gp * slices / std::max(1.0, costs.slices);
}

int hops(const Layout& mesh, NodeId from, NodeId to) {
  Route route(mesh, from, to);
  int count = 0;
  while (route.next()) ++count;
  return count;
}

/// The hop was measured with all ranks working; when some are idle, the others have cores of their own.
double hop_seconds(const RankCosts& ranks, const Layout& layout) {
  return layout.idle > 0 ? std::min(ranks.hop, RankCosts{}.hop) : ranks.hop;
}

std::vector<Layout> rings(int ranks) {
  std::vector<Layout> layouts;
  for (int renderers = 1; renderers < ranks; ++renderers)
    layouts.push_back({.gps = ranks - renderers, .renderers = renderers});
  layouts.push_back({.gps = ranks, .renderers = ranks, .placement = Placement::colocated});
  return layouts;
}

}  // namespace

MeanHops mean_hops(const Layout& layout) {
  if (!layout.routed()) return {};
  MeanHops mean{0, 0, 0};
  for (int g = 0; g < layout.gps; ++g) {
    const NodeId gp{Role::gp, g};
    mean.token += hops(layout, gp, {Role::gp, (g + 1) % layout.gps}) / double(layout.gps);
    for (int r = 0; r < layout.renderers; ++r) {
      const NodeId renderer{Role::renderer, r};
      const double pairs = double(layout.gps) * layout.renderers;
      mean.payload += hops(layout, gp, renderer) / pairs;
      mean.accept += hops(layout, renderer, gp) / pairs;
    }
  }
  return mean;
}

double FrameCosts::renderer() const { return std::accumulate(region.begin(), region.end(), 0.0); }

const char* name(Limit limit) {
  switch (limit) {
    case Limit::gps:
      return "the GPs";
    case Limit::renderers:
      return "the Renderers";
    case Limit::cores:
      break;
  }
  return "the cores";
}

Prediction predict(const FrameCosts& costs, const RankCosts& ranks, const Layout& layout) {
  Prediction p;
  p.layout = layout;
  const auto renderers = by_renderer(costs, layout.renderers);
  double longest = 0;
  if (layout.placement == Placement::colocated) {
    for (int rank = 0; rank < layout.working_ranks(); ++rank) {
      const double gp = rank < layout.gps ? gp_seconds(costs, rank, layout) : 0;
      const double renderer = rank < layout.renderers ? renderers[std::size_t(rank)] : 0;
      if (rank > 0 && gp + renderer <= longest) continue;
      longest = gp + renderer;
      p.gp = gp;
      p.renderer = renderer;
    }
  } else {
    p.gp = gp_seconds(costs, 0, layout);
    p.renderer = *std::max_element(renderers.begin(), renderers.end());
    longest = std::max(p.gp, p.renderer);
  }
  const int cores = std::max(1, std::min(ranks.cores, layout.working_ranks()));
  p.shared = (costs.gp + costs.frame * layout.gps + costs.renderer()) / cores;
  p.limit = p.shared > longest * (1 + 1e-9) ? Limit::cores
            : p.gp >= p.renderer            ? Limit::gps
                                            : Limit::renderers;
  // A token passes a bundle by payload, accept and token.
  const MeanHops mean = mean_hops(layout);
  const double bundles = costs.slices / layout.bundle,
               hops = bundles * (mean.token + mean.payload + mean.accept);
  p.tokens =
      layout.working_ranks() == 1
          ? 0
          : hops * std::max(hop_seconds(ranks, layout), layout.renderers * ranks.message_software / cores) +
                bundles * ranks.token * std::max(1.0, double(layout.renderers) / layout.gps);
  p.seconds = std::max(longest, p.shared) + p.tokens;
  if (layout.working_ranks() > ranks.cores) p.seconds *= ranks.sharing;
  return p;
}

std::vector<Layout> possible_layouts(int ranks, bool meshes, int cores) {
  std::vector<Layout> layouts = rings(ranks);
  if (cores > 0 && cores < ranks) {
    for (Layout layout : rings(cores)) {
      layout.idle = ranks - cores;
      layouts.push_back(layout);
    }
  }
  for (int rows = 2; meshes && rows <= ranks / 3; ++rows)
    for (const int ends : {1, 2}) {
      const int gps = ranks - ends * rows;
      if (gps >= 2 * rows && gps % rows == 0) layouts.push_back(mesh_layout(gps / rows, rows, ends * rows));
    }
  return layouts;
}

std::vector<Layout> in_bundles(std::vector<Layout> layouts, int bundle) {
  for (Layout& layout : layouts) layout.bundle = bundle;
  return layouts;
}

std::vector<Prediction> predict_all(const FrameCosts& costs, const RankCosts& ranks,
                                    const std::vector<Layout>& layouts) {
  std::vector<Prediction> all;
  for (const Layout& layout : layouts) all.push_back(predict(costs, ranks, layout));
  const auto order = [](const Prediction& p) {
    return std::tuple(p.seconds, p.layout.renderers, p.layout.gps, p.layout.placement, p.layout.topology);
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const Prediction& a, const Prediction& b) { return order(a) < order(b); });
  return all;
}

std::optional<Layout> colocated_ring(const std::vector<Layout>& layouts) {
  std::optional<Layout> found;
  for (const Layout& layout : layouts)
    if (layout.placement == Placement::colocated && layout.topology == Topology::ring &&
        (!found || layout.idle > found->idle))
      found = layout;
  return found;
}

std::string describe(const Layout& layout) {
  const auto some = [](int count, const char* what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
  };
  const std::string bundles = layout.bundle > 1 ? fmt::format(", bundles of {}", layout.bundle) : "";
  if (layout.topology == Topology::mesh)
    return fmt::format("mesh of {}x{} + {}{}", layout.mesh_columns, layout.mesh_rows,
                       some(layout.renderers, "Renderer"), bundles);
  const std::string working =
      layout.placement == Placement::colocated
          ? some(layout.working_ranks(), "colocated rank") +
                (layout.renderers < layout.gps ? fmt::format(", {} of them drawing", layout.renderers) : "")
          : fmt::format("{} + {}", some(layout.gps, "GP"), some(layout.renderers, "Renderer"));
  return working + bundles + (layout.idle > 0 ? fmt::format(", {} idle", layout.idle) : "");
}

std::string describe(const FrameCosts& costs) {
  const auto each = [](double seconds, double count) { return count > 0 ? 1e9 * seconds / count : 0.0; };
  const std::string drawing = costs.splats > 0
                                  ? fmt::format("{:.0f} {} of {:.1f} ns", costs.splats, costs.items,
                                                each(costs.renderer(), costs.splats))
                                  : fmt::format("{:.2f} ms", 1e3 * costs.renderer());
  return fmt::format(
      "{:.0f} visible voxels of {:.1f} ns on a GP, {} on a Renderer, {:.2f} ms a frame on each GP",
      costs.visible_voxels, each(costs.gp, costs.visible_voxels), drawing, 1e3 * costs.frame);
}

std::string to_table(const std::vector<Prediction>& predictions) {
  std::string text = fmt::format("  {:<28}{:>10}{:>10}{:>12}{:>10}{:>10}   limit\n", "ms a frame",
                                 "predicted", "GP", "Renderer", "cores", "tokens");
  for (const Prediction& p : predictions)
    text += fmt::format("  {:<28}{:>10.2f}{:>10.2f}{:>12.2f}{:>10.2f}{:>10.2f}   {}\n", describe(p.layout),
                        1e3 * p.seconds, 1e3 * p.gp, 1e3 * p.renderer, 1e3 * p.shared, 1e3 * p.tokens,
                        name(p.limit));
  return text;
}

}  // namespace ringsplat::app

#include "program/layouts.hpp"

#include <fmt/format.h>

namespace ringsplat::app {
namespace {

std::vector<Layout> rings(int ranks) {
  std::vector<Layout> layouts;
  for (int renderers = 1; renderers < ranks; ++renderers)
    layouts.push_back({.gps = ranks - renderers, .renderers = renderers});
  for (int renderers = ranks; renderers > ranks / 16 && renderers > 0; renderers /= 2)
    layouts.push_back({.gps = ranks, .renderers = renderers, .placement = Placement::colocated});
  return layouts;
}

}  // namespace

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

}  // namespace ringsplat::app

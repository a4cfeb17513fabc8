#pragma once
// Simulates the payloads on a mesh's links while tokens move in step, with pure functions.
#include <functional>
#include <map>
#include <vector>

#include "net/mesh.hpp"

namespace ringsplat::test {

using Routing = std::function<std::vector<Hop>(const Layout&, NodeId source, NodeId destination)>;

struct Traffic {
  int payloads = 0, arrived = 0;
  int collisions = 0;     ///< uses of a directed link beyond the first in a step
  int wrong_lengths = 0;  ///< payloads whose hops are not the manhattan distance
};

/// Rows in the direction of travel, columns, and the hop into the Renderer; independent of route().
inline int manhattan_distance(const Layout& mesh, int gp, int renderer) {
  const int rows = mesh.mesh_rows, x = gp % mesh.mesh_columns, y = gp / mesh.mesh_columns;
  const bool left = renderer < rows;
  const int columns = left ? x : mesh.mesh_columns - 1 - x;
  const int row = renderer % rows;
  const int vertical = mesh.renderers <= rows ? std::abs(row - y)
                       : left                 ? (row - y + rows) % rows
                                              : (y - row + rows) % rows;
  return vertical + columns + 1;
}

/// Simulates a traversal in which all Renderers get a payload of every slice.
inline Traffic in_step_traffic(const Layout& mesh, int slices, bool ascending, const Routing& routing) {
  Traffic traffic;
  const int renderers = mesh.renderers;
  for (int time = 0; time < slices + renderers; ++time) {
    std::map<Link, int> uses;
    for (int place = 0; place < renderers; ++place) {
      const int step = time - place;
      if (step < 0 || step >= slices) continue;
      const int renderer = ascending ? place : renderers - 1 - place;
      const int gp = (ascending ? step : slices - 1 - step) % mesh.gps;
      const auto hops = routing(mesh, {Role::gp, gp}, {Role::renderer, renderer});
      ++traffic.payloads;
      if (!hops.empty() && hops.back().to == mesh.rank_of({Role::renderer, renderer})) ++traffic.arrived;
      if (int(hops.size()) != manhattan_distance(mesh, gp, renderer)) ++traffic.wrong_lengths;
      for (const Hop& hop : hops)
        if (++uses[hop.link] > 1) ++traffic.collisions;
    }
  }
  return traffic;
}

}  // namespace ringsplat::test

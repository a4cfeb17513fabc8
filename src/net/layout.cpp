#include "net/message.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "ringsplat/base/error.hpp"

namespace ringsplat {

int Layout::working_ranks() const {
  return placement == Placement::dedicated ? gps + renderers : std::max(gps, renderers);
}

int Layout::rank_of(NodeId node) const {
  if (node.role == Role::frame_buffer) return 0;
  const bool behind_gps = node.role == Role::renderer && placement == Placement::dedicated;
  return behind_gps ? gps + node.index : node.index;
}

std::vector<NodeId> Layout::nodes_on(int rank) const {
  std::vector<NodeId> nodes;
  if (rank < gps) nodes.push_back({Role::gp, rank});
  const int renderer = placement == Placement::dedicated ? rank - gps : rank;
  if (renderer >= 0 && renderer < renderers) nodes.push_back({Role::renderer, renderer});
  if (rank == 0) nodes.push_back(frame_buffer_id);
  return nodes;
}

Layout mesh_layout(int columns, int rows, int renderers, Routing routing) {
  return {.gps = columns * rows,
          .renderers = renderers,
          .topology = Topology::mesh,
          .mesh_columns = columns,
          .mesh_rows = rows,
          .routing = routing};
}

void check(const Layout& layout) {
  if (layout.gps < 1)
    throw InputError(fmt::format("--gps is {}, but a frame needs at least one GP", layout.gps),
                     "use --gps 1 or more");
  if (layout.renderers < 1)
    throw InputError(
        fmt::format("--renderers is {}, but a frame needs at least one Renderer", layout.renderers),
        "use --renderers 1 or more");
  if (layout.bundle < 1 || layout.bundle > most_slices_of_bundle)
    throw InputError(fmt::format("--bundle is {}", layout.bundle),
                     fmt::format("a bundle has 1 to {} slices", most_slices_of_bundle));
  if (layout.idle < 0) throw InputError(fmt::format("{} ranks cannot be idle", layout.idle));
  if (layout.topology != Topology::mesh) return;
  const int columns = layout.mesh_columns, rows = layout.mesh_rows;
  constexpr int most = 4096;  // keeps columns × rows far inside an int
  if (columns < 1 || rows < 1 || columns > most || rows > most)
    throw InputError(fmt::format("--topology mesh needs a shape of 1 to {} columns and rows", most),
                     "for instance --mesh 4x4");
  if (layout.gps != columns * rows)
    throw InputError(
        fmt::format("--mesh {}x{} has {} GPs, but --gps is {}", columns, rows, columns * rows, layout.gps),
        "leave --gps out: the mesh says how many there are");
  if (layout.renderers > 2 * rows)
    throw InputError(
        fmt::format("--renderers is {}, but a mesh of {} row(s) has only {} row ends for Renderers",
                    layout.renderers, rows, 2 * rows),
        fmt::format("use --renderers {} or fewer, or a mesh with more rows", 2 * rows));
  if (layout.idle > 0)
    throw InputError(fmt::format("a mesh has no idle ranks, but {} are asked for", layout.idle));
  if (layout.placement != Placement::dedicated)
    throw InputError("a mesh has its Renderers at the ends of its rows, on ranks of their own",
                     "leave out --roles colocated, or use --topology ring");
}

void check(const Header& header, const Layout& layout) {
  const int nodes[] = {layout.gps, layout.renderers, 1, layout.ranks()};  // by role
  const auto exists = [&](NodeId node) { return node.index >= 0 && node.index < nodes[int(node.role)]; };
  if (!exists(header.from()) || !exists(header.to()))
    throw RunError(fmt::format("a {} from {} to {} names a node this run does not have", name(header.kind),
                               to_string(header.from()), to_string(header.to())));
  const auto place = token_place(header);
  if (header.frame < 0 || (place && (place->step < 0 || !exists({Role::renderer, place->renderer}))))
    throw RunError(fmt::format(
        "a {} from {} has frame {}{}", name(header.kind), to_string(header.from()), header.frame,
        place ? fmt::format(", step {}, Renderer {}", place->step, place->renderer) : std::string()));
}

std::vector<int> announcement_children(int rank, int ranks) {
  std::vector<int> children;
  // Rank r's children are r + 2^k for every 2^k above r's own highest bit.
  for (long long bit = 1; rank + bit < ranks; bit *= 2)
    if (bit > rank) children.push_back(int(rank + bit));
  return children;
}

}  // namespace ringsplat

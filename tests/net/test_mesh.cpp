#include "net/mesh.hpp"

#include <fmt/format.h>

#include <functional>
#include <map>
#include <set>
#include <tuple>

#include "net/mesh_traffic.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const std::vector<Layout> small_meshes{mesh_layout(1, 1, 1), mesh_layout(1, 1, 2), mesh_layout(2, 2, 1),
                                       mesh_layout(2, 2, 2), mesh_layout(2, 2, 3), mesh_layout(2, 2, 4),
                                       mesh_layout(3, 3, 3), mesh_layout(3, 3, 6), mesh_layout(4, 4, 8),
                                       mesh_layout(3, 5, 5), mesh_layout(3, 5, 9), mesh_layout(6, 2, 4),
                                       mesh_layout(1, 4, 8), mesh_layout(5, 1, 2), mesh_layout(5, 5, 10)};

std::string shape(const Layout& mesh) {
  return fmt::format("{}x{}+{}", mesh.mesh_columns, mesh.mesh_rows, mesh.renderers);
}

std::vector<NodeId> all_nodes(const Layout& mesh) {
  std::vector<NodeId> nodes;
  for (int rank = 0; rank < mesh.ranks(); ++rank)
    for (const NodeId node : mesh.nodes_on(rank)) nodes.push_back(node);
  return nodes;
}

/// The forbidden route: first along the row to the edge, then along the edge's column.
std::vector<Hop> row_first(const Layout& mesh, NodeId source, NodeId destination) {
  std::vector<Hop> hops;
  const MeshPlace there = place_of(mesh, mesh.rank_of(destination));
  const int edge = there.x < 0 ? 0 : mesh.mesh_columns - 1;
  const auto go = [&](int from, Direction direction) {
    hops.push_back({{from, direction}, neighbour(mesh, from, direction).value(), 0});
    return hops.back().to;
  };
  int at = mesh.rank_of(source);
  while (place_of(mesh, at).x != edge)
    at = go(at, place_of(mesh, at).x > edge ? Direction::west : Direction::east);
  while (place_of(mesh, at).y != there.y) {
    const int y = place_of(mesh, at).y;
    at = go(at, wraps(mesh)   ? (there.x < 0 ? Direction::south : Direction::north)
                : y < there.y ? Direction::south
                              : Direction::north);
  }
  go(at, there.x < 0 ? Direction::west : Direction::east);
  return hops;
}

/// True when the relation "a message keeps a slot of this channel while it waits for that one" has a cycle.
bool channels_form_a_cycle(const Layout& mesh, bool with_classes) {
  using Channel = std::pair<Link, int>;
  std::map<Channel, std::set<Channel>> waits_for;
  for (const NodeId source : all_nodes(mesh))
    for (const NodeId destination : all_nodes(mesh)) {
      const auto hops = route(mesh, source, destination);
      for (std::size_t k = 1; k < hops.size(); ++k)
        waits_for[{hops[k - 1].link, with_classes ? hops[k - 1].buffer_class : 0}].insert(
            {hops[k].link, with_classes ? hops[k].buffer_class : 0});
    }
  std::map<Channel, int> state;  // 1: on the path, 2: done
  const std::function<bool(const Channel&)> closes = [&](const Channel& channel) {
    if (state[channel] != 0) return state[channel] == 1;
    state[channel] = 1;
    for (const auto& next : waits_for[channel])
      if (closes(next)) return true;
    state[channel] = 2;
    return false;
  };
  std::set<Channel> channels;
  for (const auto& [channel, next] : waits_for) channels.insert(channel);
  return std::any_of(channels.begin(), channels.end(), closes);
}

std::string refusal(const Layout& layout) {
  return message_of([&] { check(layout); });
}

}  // namespace

TEST_CASE("in step, no directed link of an N x N mesh is used twice, whichever way slices are traversed") {
  for (int n = 2; n <= 16; ++n)
    for (const int renderers : {n, 2 * n})
      for (const bool ascending : {true, false}) {
        const Layout mesh = mesh_layout(n, n, renderers);
        const int slices = 2 * n * n + 3;
        const Traffic traffic = in_step_traffic(mesh, slices, ascending, route);
        INFO(shape(mesh) << (ascending ? " ascending" : " descending"));
        REQUIRE(traffic.payloads == slices * renderers);
        REQUIRE(traffic.arrived == traffic.payloads);
        REQUIRE(traffic.wrong_lengths == 0);
        REQUIRE(traffic.collisions == 0);
      }
}

TEST_CASE(
    "in step, nothing collides in a mesh with at least as many columns as rows, nor with fewer Renderers") {
  for (int rows = 1; rows <= 6; ++rows)
    for (int columns = rows; columns <= 8; ++columns)
      for (int renderers = 1; renderers <= 2 * rows; ++renderers)
        for (const bool ascending : {true, false}) {
          const Layout mesh = mesh_layout(columns, rows, renderers);
          const Traffic traffic = in_step_traffic(mesh, 2 * mesh.gps + 1, ascending, route);
          INFO(shape(mesh));
          REQUIRE(traffic.arrived == traffic.payloads);
          REQUIRE(traffic.wrong_lengths == 0);
          REQUIRE(traffic.collisions == 0);
        }
}

TEST_CASE(
    "the check for collisions can fail: row first collides, and so does a mesh with more rows than columns") {
  for (int n = 2; n <= 16; ++n)
    for (const int renderers : {n, 2 * n}) {
      const Layout mesh = mesh_layout(n, n, renderers);
      const Traffic traffic = in_step_traffic(mesh, 2 * n * n + 3, true, row_first);
      INFO(shape(mesh));
      REQUIRE(traffic.arrived == traffic.payloads);
      REQUIRE(traffic.wrong_lengths == 0);
      // Two by two is too small for collisions: rows and columns have one link a direction, or two that
      // alternate.
      if (n > 2) REQUIRE(traffic.collisions > 0);
    }
  CHECK(in_step_traffic(mesh_layout(2, 6, 6), 40, true, route).collisions > 0);
}

TEST_CASE("every message between two nodes arrives and passes no rank twice and no Renderer") {
  for (const Layout& mesh : small_meshes)
    for (const NodeId source : all_nodes(mesh))
      for (const NodeId destination : all_nodes(mesh)) {
        INFO(shape(mesh) << ": " << to_string(source) << " to " << to_string(destination));
        const auto hops = route(mesh, source, destination);
        std::set<int> passed{mesh.rank_of(source)};
        for (const Hop& hop : hops) {
          REQUIRE(neighbour(mesh, hop.link.from, hop.link.direction) == hop.to);
          REQUIRE(passed.insert(hop.to).second);
        }
        REQUIRE((hops.empty() ? mesh.rank_of(source) : hops.back().to) == mesh.rank_of(destination));
        for (std::size_t k = 0; k + 1 < hops.size(); ++k) REQUIRE(hops[k].to < mesh.gps);
      }
}

TEST_CASE("the way to a GP is a shortest one from another GP") {
  for (const Layout& mesh : small_meshes)
    for (int a = 0; a < mesh.gps; ++a)
      for (int b = 0; b < mesh.gps; ++b) {
        const MeshPlace from = place_of(mesh, a), to = place_of(mesh, b);
        int vertical = std::abs(from.y - to.y);
        if (wraps(mesh)) vertical = std::min(vertical, mesh.mesh_rows - vertical);
        INFO(shape(mesh) << ": " << a << " to " << b);
        const auto way = route(mesh, {Role::gp, a}, {Role::gp, b});
        REQUIRE(int(way.size()) == vertical + std::abs(from.x - to.x));
        // Down, when both ways round are as long.
        if (wraps(mesh) && 2 * vertical == mesh.mesh_rows)
          REQUIRE(way.front().link.direction == Direction::south);
      }
}

TEST_CASE(
    "no chain of waiting messages can close, and without the second buffer class one could where the mesh "
    "wraps") {
  for (const Layout& mesh : small_meshes) {
    INFO(shape(mesh));
    REQUIRE_FALSE(channels_form_a_cycle(mesh, true));
  }
  CHECK(channels_form_a_cycle(mesh_layout(3, 3, 6), false));
  CHECK(channels_form_a_cycle(mesh_layout(5, 5, 10), false));
  CHECK_FALSE(channels_form_a_cycle(mesh_layout(5, 5, 5), false));
}

TEST_CASE("links have a name of their own each and a partner in the other direction") {
  for (const Layout& mesh : small_meshes) {
    std::set<std::string> names;
    std::map<std::pair<int, int>, int> between;
    for (const Link& link : links(mesh)) {
      REQUIRE(names.insert(name(mesh, link)).second);
      ++between[{link.from, neighbour(mesh, link.from, link.direction).value()}];
    }
    for (const auto& [ranks, count] : between) REQUIRE(between[{ranks.second, ranks.first}] == count);
  }
  const Layout mesh = mesh_layout(4, 4, 8);
  CHECK(links(mesh).size() == 4 * 2 * 3 + 2 * 4 * 4 + 2 * 8);
  CHECK(name(mesh, {9, Direction::north}) == "x1y2N");
  CHECK(name(mesh, {16, Direction::east}) == "R0E");
  CHECK(name(mesh, {23, Direction::west}) == "R7W");
  CHECK(neighbour(mesh, 23, Direction::west) == 15);
  CHECK(neighbour(mesh, 1, Direction::north) == 13);
  CHECK_FALSE(neighbour(mesh_layout(4, 4, 4), 1, Direction::north));
  CHECK_FALSE(neighbour(mesh, 23, Direction::east));
}

TEST_CASE("a mesh that cannot be is refused and the reason is given") {
  CHECK(refusal(mesh_layout(4, 4, 8)).empty());
  CHECK(refusal(mesh_layout(4, 4, 1)).empty());
  CHECK(says(refusal(mesh_layout(4, 4, 9)), "only 8 row ends"));
  Layout shapeless{.gps = 4, .topology = Topology::mesh};
  CHECK(says(refusal(shapeless), "--mesh"));
  Layout too_few = mesh_layout(4, 4, 4);
  too_few.gps = 15;
  CHECK(says(refusal(too_few), "has 16 GPs, but --gps is 15"));
  Layout colocated = mesh_layout(2, 2, 2);
  colocated.placement = Placement::colocated;
  CHECK(says(refusal(colocated), "--roles"));
}

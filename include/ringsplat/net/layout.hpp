#pragma once
#include <vector>

namespace ringsplat {

struct NodeId;

enum class Topology { ring, mesh };
enum class Placement { dedicated, colocated };
/// How messages cross a mesh: from neighbour to neighbour, or each straight to its rank.
enum class Routing { manhattan, direct };

/// Which rank hosts which node: pure functions of a few numbers, the same on every rank.
///
/// Dedicated: GPs are ranks 0 … G−1, Renderers G … G+R−1. Colocated: rank p hosts GP p and Renderer p, as
/// far as there are such. The frame buffer is on rank 0.
///
/// A mesh (Neumann 1992, section 3.1) has its GPs in rows, numbered row by row from the upper left, so that
/// slices are dealt row by row. Renderer r stands at the left end of row r; from the number of rows on, at
/// the right end of row r − rows, and then the mesh wraps vertically.
struct Layout {
  int gps = 1, renderers = 1;  ///< a mesh has columns × rows GPs
  Placement placement = Placement::dedicated;
  Topology topology = Topology::ring;
  int mesh_columns = 0, mesh_rows = 0;
  Routing routing = Routing::manhattan;
  int idle = 0;    ///< ranks behind all others that host no node
  int bundle = 1;  ///< consecutive slices that one GP gets and that travel under one token; 1 is the paper

  int ranks() const { return working_ranks() + idle; }
  int working_ranks() const;
  int rank_of(NodeId node) const;
  std::vector<NodeId> nodes_on(int rank) const;
  /// True when messages travel from neighbour to neighbour over the mesh's links.
  bool routed() const { return topology == Topology::mesh && routing == Routing::manhattan; }
  bool operator==(const Layout&) const = default;
};

/// More slices than any volume has.
inline constexpr int most_slices_of_bundle = 1 << 20;

/// A mesh of columns × rows GPs; its Renderers are on ranks of their own.
Layout mesh_layout(int columns, int rows, int renderers, Routing routing = Routing::manhattan);

/// Throws InputError naming the option: a count below 1; a bundle of too many slices; a mesh without a shape,
/// with a shape that its GPs do not fill, with more Renderers than row ends, or with Renderers on the GPs'
/// ranks.
void check(const Layout& layout);

}  // namespace ringsplat

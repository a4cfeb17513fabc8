#pragma once
#include <string>
#include <vector>

#include "ringsplat/net/layout.hpp"

/// The ways to give ranks their roles.
namespace ringsplat::app {

/// All ways to give `ranks` ranks their roles: rings with every dedicated split, and with all of them GPs, of
/// which all, half, a quarter or an eighth are Renderers, too; with `meshes` also every mesh of at least 2x2
/// GPs that uses all ranks, with a Renderer at the left end or at both ends of each row. When `cores` is not
/// 0 and there are more ranks, also rings of `cores` ranks with the others idle.
std::vector<Layout> possible_layouts(int ranks, bool meshes, int cores = 0);

/// These layouts with bundles of so many slices.
inline std::vector<Layout> in_bundles(std::vector<Layout> layouts, int bundle) {
  for (Layout& layout : layouts) layout.bundle = bundle;
  return layouts;
}

/// "4 GPs + 2 Renderers", "3 colocated ranks, 5 idle", "mesh of 4x3 + 6 Renderers".
std::string describe(const Layout& layout);

}  // namespace ringsplat::app

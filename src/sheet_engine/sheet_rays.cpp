#include "sheet_engine/sheet_rays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

#include "ringsplat/base/error.hpp"

namespace ringsplat {

SheetRays make_sheet_rays(const SheetFrame& frame) {
  const FrameGeometry& g = frame.geometry;
  const auto [u, v] = in_plane(g.traversal.axis);
  const glm::dmat2 to_lattice =
      glm::inverse(glm::dmat2(glm::dvec2(g.view.linear[u]), glm::dvec2(g.view.linear[v])));
  const glm::dvec2 origin = to_lattice * (glm::dvec2(0.5) - glm::dvec2(g.view.offset)),
                   shear = to_lattice * glm::dvec2(g.view.linear[static_cast<int>(g.traversal.axis)]);
  SheetRays rays;
  rays.grid.voxels[0] = g.grid.dims[u];
  rays.grid.voxels[1] = g.grid.dims[v];
  rays.patches = true;
  for (int k = 0; k < 2; ++k) {
    const double reach = rays.grid.voxels[k] + std::abs(shear[k]) * g.slices;
    if (!(reach < most_voxels))
      throw InputError(fmt::format("seen along the rays, the {} slices span {:.0f} voxels, more than {:.0f}",
                                   name(g.traversal.axis), reach, most_voxels),
                       "use --engine splats, --undersample, or another view");
    constexpr double unit = double(std::int64_t{1} << 40), most_seen = 1 << 22;
    const double seen =
        std::abs(origin[k]) + g.width * std::abs(to_lattice[0][k]) + g.height * std::abs(to_lattice[1][k]);
    if (!(seen < most_seen))
      throw InputError(
          fmt::format("the picture shows {:.3g} voxels around a volume of {}", seen, rays.grid.voxels[k]),
          "use a larger --zoom");
    const auto fixed = [](double x) { return static_cast<std::int64_t>(std::llround(x * unit)); };
    rays.grid.origin[k] = fixed(origin[k]);
    rays.grid.step_x[k] = fixed(to_lattice[0][k]);
    rays.grid.step_y[k] = fixed(to_lattice[1][k]);
    rays.shear[k] = shear[k];
    const double tile = (tile_side - 1) * (std::abs(to_lattice[0][k]) + std::abs(to_lattice[1][k]));
    // The patch has the voxel below the tile's lowest position in any sheet, two before it and five behind.
    rays.patches = rays.patches && tile + std::abs(shear[k]) < 4;
  }
  return rays;
}

SheetSlab make_slab(const SheetFrame& frame, const SheetRays& rays, int step) {
  const int slices = frame.geometry.slices;
  SheetSlab slab;
  slab.step = step + 1;
  slab.face = step < 0 || step == slices - 1;
  slab.pieces = slab.face ? 1 : frame.sheets.slabs;
  const double way = frame.geometry.traversal.ascending ? 1 : -1;
  const double front = step < 0 ? frame.slice_at(0) - 0.5 * way : frame.slice_at(step);
  const double length = slab.face ? 0.5 : 1;
  for (int i = 0; i <= slab.pieces; ++i) {
    const double at = front + way * length * i / slab.pieces;
    slab.shift_u[std::size_t(i)] = fixed_position(rays.shear[0] * at);
    slab.shift_v[std::size_t(i)] = fixed_position(rays.shear[1] * at);
  }
  return slab;
}

}  // namespace ringsplat

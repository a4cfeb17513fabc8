#pragma once
#include "heat_equation.hpp"
#include "ringsplat/ringsplat.hpp"

/// Grey smoke where it is warm, glowing where it is hot.
inline ringsplat::TransferFunction glow() {
  ringsplat::TransferFunction function;
  function.name = "glow";
  function.colours = {{0, {0.1, 0.1, 0.4}}, {0.3, {0.7, 0.1, 0.1}}, {1.5, {1, 0.6, 0.1}}, {4, {1, 1, 0.8}}};
  function.opacities = {{0.01, 0}, {0.3, 0.01}, {1.5, 0.06}, {4, 0.3}};
  return function;
}

inline ringsplat::Grid lattice(int cells) {
  ringsplat::Grid grid;
  grid.dims = glm::ivec3(cells);
  grid.spacing = glm::dvec3(1.0 / cells);
  grid.type = ringsplat::ScalarType::float32;
  return grid;
}

/// Where the solver's cells lie, without the ghosts around them.
inline ringsplat::Strides strides_of(const HeatEquation& heat) {
  constexpr std::ptrdiff_t bytes = sizeof(float);
  return {bytes, bytes * heat.row(), bytes * heat.plane()};
}

/// This rank's block of the session. The solver goes to and fro between two arrays, so that its place is told
/// anew after each step, by update_block().
inline void add_cells(ringsplat::Session& session, const HeatEquation& heat) {
  const auto& [x0, y0, z0] = heat.first();
  const auto& [x1, y1, z1] = heat.end();
  session.set_grid(lattice(heat.cells()));
  if (!heat.has_cells()) return;
  session.add_block({{x0, y0, z0}, {x1, y1, z1}}, heat.temperature(), strides_of(heat));
}

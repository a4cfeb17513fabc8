#pragma once
#include <cstddef>
#include <cstdint>

namespace ringsplat {

/// A table of one lattice cell, and a row of pixels as a line through the lattice.
struct LatticeRow {
  const float* table = nullptr;  ///< [height + 1][width + 1], of a function with period 1 in u and v
  int width = 1, height = 1;     ///< steps a cell
  double voxel_x = 0;            ///< pixels; u and v count from there
  double u_step = 0, u_start = 0, v_step = 0, v_start = 0;  ///< u = u_step · right + u_start
};

/// Interpolates the table linearly at the centres of the pixels x, x + 1 … of the row. A pixel's bits depend
/// neither on where the row begins nor on the vector width. Writes up to seven floats beyond `count`.
void lattice_factors(const LatticeRow& row, std::int64_t x, std::size_t count, float* factors);

}  // namespace ringsplat

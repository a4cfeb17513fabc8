#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "ringsplat/classify/normals.hpp"

namespace ringsplat {

/// Normals on an octahedral lattice (Meyer et al. 2010; Cigolle et al. 2014).
///
/// Each of the octahedron's faces carries the lattice points (a, b, c) ≥ 0 with a + b + c = 127: 4 · 127² + 2
/// = 64518 directions in all, each with one code, from 1 on. Two things make them more even than a square
/// grid with rounded coordinates (0.95 degrees): a coordinate is |x| (k |n| + |x|) up to a common factor,
/// which takes points from the vertices, where they crowd, to the faces; and rounding goes to the nearest
/// point of the triangular lattice on the face.
inline constexpr int lattice_n = 127;
inline constexpr double lattice_warp = 2.5;
inline constexpr int lattice_codes = 4 * lattice_n * lattice_n + 2;
static_assert(lattice_codes < int(normal_codes));

/// A lattice point: i and j carry the signs of x and y; z is below zero in the lower half.
struct LatticePoint {
  int i, j;
  bool lower;
};

/// The codes count through the upper half (|i| + |j| ≤ n, the equator included) and then the lower one
/// (|i| + |j| < n), row by row. rows[i + n] + j is the code of (i, j).
struct LatticeRows {
  std::array<int, 2 * lattice_n + 1> upper{}, lower{};
};
constexpr LatticeRows make_lattice_rows() {
  LatticeRows rows;
  int code = 1;
  for (int half = 0; half < 2; ++half)
    for (int i = -lattice_n; i <= lattice_n; ++i) {
      const int reach = lattice_n - half - (i < 0 ? -i : i);
      (half == 0 ? rows.upper : rows.lower)[std::size_t(i + lattice_n)] = code + reach;
      if (reach >= 0) code += 2 * reach + 1;
    }
  return rows;
}
inline constexpr LatticeRows lattice_rows = make_lattice_rows();

inline NormalCode code_of(const LatticePoint& p) {
  const auto& rows = p.lower ? lattice_rows.lower : lattice_rows.upper;
  return NormalCode(rows[std::size_t(p.i + lattice_n)] + p.j);
}

/// The code of a direction that is zero or whose length is between 1e-90 and 1e90.
inline NormalCode encode_moderate(double x, double y, double z) {
  const double ax = std::abs(x), ay = std::abs(y), az = std::abs(z);
  const double length = std::sqrt(x * x + y * y + z * z);
  if (!(length > 0)) return no_normal;
  const double warp = lattice_warp * length;
  const double scale = lattice_n / (length * (lattice_warp * (ax + ay + az) + length));
  const double a = ax * (warp + ax) * scale, b = ay * (warp + ay) * scale, c = az * (warp + az) * scale;
  int i = int(a + 0.5), j = int(b + 0.5), l = int(c + 0.5);
  if (const int excess = i + j + l - lattice_n; excess != 0) {
    // Three roundings missed the face's plane: the one that erred most goes back (nearest point of A2).
    const double sign = excess, ea = sign * (i - a), eb = sign * (j - b), ec = sign * (l - c);
    if (ea >= eb && ea >= ec)
      i -= excess;
    else if (eb >= ec)
      j -= excess;
    else
      l -= excess;
  }
  return code_of({x < 0 ? -i : i, y < 0 ? -j : j, z < 0 && l > 0});
}

}  // namespace ringsplat

#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "classify/normals.hpp"

namespace ringsplat {

/// Normals on an octahedral lattice (Meyer et al. 2010; Cigolle et al. 2014).
///
/// Each of the octahedron's faces carries the lattice points (a, b, c) ≥ 0 with a + b + c = 126: 4 · 126² + 2
/// = 63506 directions in all, each with one code, from 1 on. Two things make them more even than a square
/// grid with rounded coordinates (0.95 degrees): a coordinate is |x| (k |n| + |x|) up to a common factor,
/// which takes points from the vertices, where they crowd, to the faces; and rounding goes to the nearest
/// point of the triangular lattice on the face.
///
/// Directions turn and mirror with their codes. A direction half-way between (k, k + 1, l) and (k + 1, k, l),
/// as those with |x| = |y| may be, is its own mirror image, but neither of the two points is; such points
/// (k + ½, k + ½, l), and those of the other two pairs of axes, therefore have codes of their own: 63 on each
/// of the 3 planes' parts in each octant.
///
/// Of a code and the opposite direction's the sum is lattice_codes + 1: points between of the upper octants,
/// points above the equator, on it, below it, points between of the lower octants, those after the equator's
/// middle in the reverse order of those before it. So what is the same for both needs half a table.
inline constexpr int lattice_n = 126;
inline constexpr double lattice_warp = 2.5;
inline constexpr int lattice_points = 4 * lattice_n * lattice_n + 2;
inline constexpr int points_between = lattice_n / 2;  ///< on one plane, in one octant
inline constexpr int all_between = 3 * 8 * points_between;
inline constexpr int lattice_codes = lattice_points + all_between;
static_assert(lattice_codes < int(normal_codes) && lattice_codes % 2 == 0);
static_assert(lattice_codes + 1 == opposite_codes);
static_assert(lattice_n % 6 == 0,
              "the diagonals must be points, and no point between on the octants' borders");

/// A lattice point: i and j carry the signs of x and y; z is below zero in the lower half.
struct LatticePoint {
  int i, j;
  bool lower;
};

inline constexpr int first_above = all_between / 2 + 1, points_on_equator = 4 * lattice_n,
                     points_above = (lattice_points - points_on_equator) / 2,
                     first_on_equator = first_above + points_above,
                     first_below = first_on_equator + points_on_equator;

/// The points above the equator (|i| + |j| < n) are numbered row by row: (i, j) is number rows[i + n] + j.
using LatticeRows = std::array<int, 2 * lattice_n + 1>;
constexpr LatticeRows make_lattice_rows() {
  LatticeRows rows{};
  int before = 0;
  for (int i = 1 - lattice_n; i < lattice_n; ++i) {
    const int reach = lattice_n - 1 - (i < 0 ? -i : i);
    rows[std::size_t(i + lattice_n)] = before + reach;
    before += 2 * reach + 1;
  }
  return rows;
}
inline constexpr LatticeRows lattice_rows = make_lattice_rows();

inline NormalCode code_of(const LatticePoint& p) {
  if (std::abs(p.i) + std::abs(p.j) < lattice_n)
    return NormalCode((p.lower ? first_below : first_above) + lattice_rows[std::size_t(p.i + lattice_n)] +
                      p.j);
  // Row by row again: (−n, 0), two points of each row, (n, 0).
  const int before = p.i == -lattice_n ? 0 : 2 * (p.i + lattice_n) - 1 + int(p.j > 0);
  return NormalCode(first_on_equator + before);
}

/// A point half-way between two: (k + ½, k + ½) along the axes `first` and its successor (x, y, z, x …). The
/// octant's bits say which of x, y, z are below zero.
struct PointBetween {
  int first, octant, k;
};
inline NormalCode code_of(const PointBetween& p) {
  const bool lower = p.octant >= 4;
  const int code = 1 + (p.first * 4 + (lower ? 7 - p.octant : p.octant)) * points_between + p.k;
  return NormalCode(lower ? lattice_codes + 1 - code : code);
}

/// The code of a direction that is zero or whose length is between 1e-90 and 1e90.
inline NormalCode encode_moderate(double x, double y, double z) {
  const double ax = std::abs(x), ay = std::abs(y), az = std::abs(z);
  // Sums in the order of size, so that a turned direction gives the same bits.
  const double most = std::max(std::max(ax, ay), az), least = std::min(std::min(ax, ay), az),
               middle = std::max(std::min(ax, ay), std::min(std::max(ax, ay), az));
  const double length = std::sqrt((least * least + middle * middle) + most * most);
  if (!(length > 0)) return no_normal;
  const double warp = lattice_warp * length;
  const double scale = lattice_n / (length * (lattice_warp * ((least + middle) + most) + length));
  const double a = ax * (warp + ax) * scale, b = ay * (warp + ay) * scale, c = az * (warp + az) * scale;
  int i = int(a + 0.5), j = int(b + 0.5), l = int(c + 0.5);
  if (const int excess = i + j + l - lattice_n; excess != 0) {
    // The rounded point is off the face's plane. Moves back the coordinate that was rounded furthest (nearest
    // point of A2); of two rounded as far, the larger; of two equal ones, each by half.
    const double sign = excess, ea = sign * (i - a), eb = sign * (j - b), ec = sign * (l - c);
    const auto before = [](double e, double size, double other_e, double other_size) {
      return e > other_e || (e == other_e && size > other_size);
    };
    const int octant = int(x < 0) + 2 * int(y < 0) + 4 * int(z < 0);
    const int down = excess > 0 ? 1 : 0;
    if (before(ea, a, eb, b) && before(ea, a, ec, c))
      i -= excess;
    else if (before(eb, b, ea, a) && before(eb, b, ec, c))
      j -= excess;
    else if (before(ec, c, ea, a) && before(ec, c, eb, b))
      l -= excess;
    else if (a == b && !before(ec, c, ea, a))
      return code_of(PointBetween{0, octant, i - down});
    else if (b == c && !before(ea, a, eb, b))
      return code_of(PointBetween{1, octant, j - down});
    else
      return code_of(PointBetween{2, octant, l - down});
  }
  return code_of(LatticePoint{x < 0 ? -i : i, y < 0 ? -j : j, z < 0 && l > 0});
}

}  // namespace ringsplat

#include "classify/normals.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <type_traits>

#include "classify/normal_lattice.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

/// The direction's component along an axis with lattice coordinate `a` (0..1), for the common factor λ.
double unwarped(double a, double lambda) {
  return 0.5 * (std::sqrt(lattice_warp * lattice_warp + 4.0 * lambda * a) - lattice_warp);
}

/// The unit direction of face coordinates (a, b, c) that sum to one: the warp's inverse.
glm::dvec3 direction_of(const glm::dvec3& face) {
  // Bisects for the λ that makes the direction a unit vector; its length grows with λ.
  double low = lattice_warp + 1.0, high = lattice_warp * std::sqrt(3.0) + 1.0;
  glm::dvec3 n{};
  for (int round = 0; round < 60; ++round) {
    const double lambda = 0.5 * (low + high);
    n = {unwarped(face.x, lambda), unwarped(face.y, lambda), unwarped(face.z, lambda)};
    (glm::dot(n, n) < 1.0 ? low : high) = lambda;
  }
  return n / glm::length(n);
}

std::vector<glm::dvec3> make_directions() {
  std::vector<glm::dvec3> directions(normal_codes, glm::dvec3(0.0));
  for (int i = 0; i <= lattice_n; ++i)
    for (int j = 0; i + j <= lattice_n; ++j) {
      const int l = lattice_n - i - j;
      const glm::dvec3 n = direction_of(glm::dvec3(i, j, l) / double(lattice_n));
      for (int octant = 0; octant < 8; ++octant) {
        const bool west = octant & 1, south = octant & 2, lower = (octant & 4) && l > 0;
        directions[code_of(LatticePoint{west ? -i : i, south ? -j : j, lower})] = {
            west ? -n.x : n.x, south ? -n.y : n.y, lower ? -n.z : n.z};
      }
    }
  for (int first = 0; first < 3; ++first)
    for (int k = 0; k < points_between; ++k) {
      glm::dvec3 face(k + 0.5);
      face[(first + 2) % 3] = lattice_n - 1 - 2 * k;
      const glm::dvec3 n = direction_of(face / double(lattice_n));
      for (int octant = 0; octant < 8; ++octant)
        directions[code_of(PointBetween{first, octant, k})] = {
            octant & 1 ? -n.x : n.x, octant & 2 ? -n.y : n.y, octant & 4 ? -n.z : n.z};
    }
  return directions;
}

template <class T>
inline constexpr bool is_exact_in_int = std::is_integral_v<T> && sizeof(T) <= 2;

/// Maps differences along the lattice axes to a world direction against the gradient: −D⁻ᵀ S⁻¹, scaled so
/// that its largest element is one. Only the direction counts.
glm::dmat3 against_gradient(const Grid& grid) {
  glm::dmat3 m = glm::transpose(glm::inverse(grid.direction));
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    m[k] *= -grid.unit_length() / grid.spacing[k];
    for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(m[k][r]));
  }
  return m / largest;
}

/// One row of a slice with the four rows around it; a row that does not exist is null.
template <class T>
struct Neighbourhood {
  const T *here, *before_y, *after_y, *before_z, *after_z;
  int count;
};

/// Handles any voxel: borders, missing neighbours, values near the end of double's range.
template <class T>
NormalCode careful_normal(const Neighbourhood<T>& rows, int x, const glm::dmat3& m) {
  const T centre = rows.here[x];
  if (!is_finite(centre)) return no_normal;
  // Twice the derivative: from neighbour to neighbour, or twice the one-sided difference where one is
  // missing; of an eighth of each value, so that no difference overflows.
  const auto along = [centre](const T* before, const T* after) {
    const bool has_before = before && is_finite(*before), has_after = after && is_finite(*after);
    const double difference =
        double(has_after ? *after : centre) / 8 - double(has_before ? *before : centre) / 8;
    return has_before && has_after ? difference : 2 * difference;
  };
  const auto at = [x](const T* row) { return row ? row + x : nullptr; };
  glm::dvec3 d{along(x > 0 ? rows.here + x - 1 : nullptr, x + 1 < rows.count ? rows.here + x + 1 : nullptr),
               along(at(rows.before_y), at(rows.after_y)), along(at(rows.before_z), at(rows.after_z))};
  const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  if (!(largest > 0)) return no_normal;
  const int exponent = std::ilogb(largest);  // no product underflows
  for (int k = 0; k < 3; ++k) d[k] = std::scalbn(d[k], -exponent);
  return encode_normal(m * d);
}

/// Inner voxels of a row, whose neighbours all exist. Equal neighbours, usual outside the object, cost three
/// subtractions. Of floats the sum of the differences' squares shows whether anything is not finite, or too
/// small for the short way.
template <class T>
void inner_normals(const Neighbourhood<T>& rows, const glm::dmat3& m, NormalCode* out) {
  using Whole = std::conditional_t<is_exact_in_int<T>, int, std::int64_t>;
  using Wide = std::conditional_t<std::is_integral_v<T>, Whole, double>;
  for (int x = 1; x + 1 < rows.count; ++x) {
    const Wide dx = Wide(rows.here[x + 1]) - Wide(rows.here[x - 1]),
               dy = Wide(rows.after_y[x]) - Wide(rows.before_y[x]),
               dz = Wide(rows.after_z[x]) - Wide(rows.before_z[x]);
    if (dx == 0 && dy == 0 && dz == 0) {
      out[x] = no_normal;
      continue;
    }
    const glm::dvec3 n = m * glm::dvec3(dx, dy, dz);
    if constexpr (!std::is_integral_v<T>) {
      const double square = n.x * n.x + n.y * n.y + n.z * n.z + 0.0 * double(rows.here[x]);
      if (!(square > 1e-180 && square < 1e180)) {
        out[x] = careful_normal(rows, x, m);
        continue;
      }
    }
    out[x] = encode_moderate(n.x, n.y, n.z);
  }
}

template <class T>
void row_normals(const Neighbourhood<T>& rows, const glm::dmat3& m, NormalCode* out) {
  const bool complete = rows.before_y && rows.after_y && rows.before_z && rows.after_z;
  if (!complete || rows.count < 3) {
    for (int x = 0; x < rows.count; ++x) out[x] = careful_normal(rows, x, m);
    return;
  }
  out[0] = careful_normal(rows, 0, m);
  inner_normals(rows, m, out);
  out[rows.count - 1] = careful_normal(rows, rows.count - 1, m);
}

}  // namespace

NormalCode encode_normal(const glm::dvec3& direction) {
  const glm::dvec3 size = glm::abs(direction);
  if (!(std::isfinite(size.x) && std::isfinite(size.y) && std::isfinite(size.z))) return no_normal;
  const double largest = std::max({size.x, size.y, size.z});
  if (!(largest > 0)) return no_normal;
  const int exponent = std::ilogb(largest);
  if (exponent > -300 && exponent < 300) return encode_moderate(direction.x, direction.y, direction.z);
  return encode_moderate(std::scalbn(direction.x, -exponent), std::scalbn(direction.y, -exponent),
                         std::scalbn(direction.z, -exponent));
}

glm::dvec3 decode_normal(NormalCode code) {
  static const std::vector<glm::dvec3> directions = make_directions();
  return directions[code];
}

void slice_normals(const Grid& grid, const std::byte* below, const std::byte* here, const std::byte* above,
                   std::span<NormalCode> out) {
  const glm::dmat3 m = against_gradient(grid);
  const int width = grid.dims.x, height = grid.dims.y;
  visit_type(grid.type, [&](auto zero) {
    using T = decltype(zero);
    const auto row = [width](const std::byte* slice, int y) {
      return slice ? reinterpret_cast<const T*>(slice) + std::size_t(y) * std::size_t(width) : nullptr;
    };
    for (int y = 0; y < height; ++y) {
      const Neighbourhood<T> rows{row(here, y),
                                  y > 0 ? row(here, y - 1) : nullptr,
                                  y + 1 < height ? row(here, y + 1) : nullptr,
                                  row(below, y),
                                  row(above, y),
                                  width};
      row_normals(rows, m, out.data() + std::size_t(y) * std::size_t(width));
    }
  });
}

}  // namespace ringsplat

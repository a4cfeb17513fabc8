#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <string>

#include "ringsplat/base/axis.hpp"
#include "ringsplat/base/fact.hpp"

namespace ringsplat {

enum class ScalarType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t size_of(ScalarType type);
std::string to_string(ScalarType type);
/// "uint8", "u8", "unsigned char", "float", ... ; throws InputError that lists the names.
ScalarType scalar_type_from(const std::string& name);

/// Calls `f(T{})` with a value of the C++ type that `type` names.
template <class F>
decltype(auto) visit_type(ScalarType type, F&& f) {
  switch (type) {
    case ScalarType::int8:
      return f(std::int8_t{});
    case ScalarType::uint8:
      return f(std::uint8_t{});
    case ScalarType::int16:
      return f(std::int16_t{});
    case ScalarType::uint16:
      return f(std::uint16_t{});
    case ScalarType::int32:
      return f(std::int32_t{});
    case ScalarType::uint32:
      return f(std::uint32_t{});
    case ScalarType::float32:
      return f(float{});
    case ScalarType::float64:
      break;
  }
  return f(double{});
}

/// A rectilinear lattice of one scalar a voxel. Voxel centres are at integer lattice
/// coordinates, x is the fastest in memory.
///
/// World position of lattice point p: origin + direction * (spacing ∘ p).
struct Grid {
  glm::ivec3 dims{0};         ///< voxels along x, y, z; all at least 1
  glm::dvec3 spacing{1.0};    ///< world units between neighbours; positive and finite
  glm::dvec3 origin{0.0};     ///< world position of voxel (0, 0, 0)
  glm::dmat3 direction{1.0};  ///< columns: world direction of each lattice axis
  ScalarType type = ScalarType::uint8;

  std::int64_t voxels() const { return std::int64_t(dims.x) * dims.y * dims.z; }
  std::uint64_t bytes() const { return std::uint64_t(voxels()) * size_of(type); }
  int slices(Axis axis) const { return dims[int(axis)]; }
  int slice_width(Axis axis) const { return dims[in_plane(axis).u]; }
  int slice_height(Axis axis) const { return dims[in_plane(axis).v]; }
  std::size_t slice_voxels(Axis axis) const {
    return std::size_t(slice_width(axis)) * std::size_t(slice_height(axis));
  }
  std::size_t slice_bytes(Axis axis) const { return slice_voxels(axis) * size_of(type); }
  /// The smallest spacing, which opacities are of.
  double unit_length() const { return std::min({spacing.x, spacing.y, spacing.z}); }
};

/// Throws InputError (naming `where`) when a dimension is below 1, the spacing not one that can be
/// drawn, the origin not finite, or the direction singular.
void check(const Grid& grid, const std::string& where);
namespace detail {
/// The same but for the spacing, which --spacing may replace: open_volume() checks that.
void check_lattice(const Grid& grid, const std::string& where);
}  // namespace detail

/// Dimensions, type, spacing, origin and direction; doubles to the last bit.
Facts facts_of(const Grid& grid);

}  // namespace ringsplat

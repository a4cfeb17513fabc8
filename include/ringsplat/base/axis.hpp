#pragma once
#include <array>

namespace ringsplat {

/// A lattice axis; x is the fastest in memory.
enum class Axis : int { x = 0, y = 1, z = 2 };

inline constexpr std::array<Axis, 3> all_axes{Axis::x, Axis::y, Axis::z};

/// The two lattice axes that span a slice perpendicular to `axis`: u is the fastest in memory.
struct InPlane {
  int u, v;
};
constexpr InPlane in_plane(Axis axis) {
  return axis == Axis::x ? InPlane{1, 2} : axis == Axis::y ? InPlane{0, 2} : InPlane{0, 1};
}
constexpr char name(Axis axis) { return "xyz"[static_cast<int>(axis)]; }

}  // namespace ringsplat

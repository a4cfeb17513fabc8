#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/mat3x3.hpp>
#include <random>
#include <span>
#include <vector>

#include "splat/region_painter.hpp"
#include "splat/splat.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat::test {

/// A lattice on the screen: pixels a voxel, turned in the picture, squeezed by an oblique view along a second
/// direction, and with voxels `anisotropy` times as long in v as in u.
struct Lattice {
  double scale = 1, turn = 0, squeeze = 1, squeeze_turn = 0, anisotropy = 1;
};

inline glm::dmat2 rotation(double angle) {
  return {std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle)};
}

/// The block that takes (u, v) to pixels.
inline glm::dmat2 block_of(const Lattice& lattice) {
  const glm::dmat2 squeeze(1, 0, 0, lattice.squeeze), stretch(1, 0, 0, lattice.anisotropy);
  return lattice.scale * rotation(lattice.squeeze_turn) * squeeze * rotation(lattice.turn) * stretch;
}

inline ViewTransform view_of(const Lattice& lattice, Axis axis = Axis::z) {
  const auto block = block_of(lattice);
  const auto plane = in_plane(axis);
  ViewTransform view;
  view.linear = glm::dmat3(0.0);
  view.linear[plane.u] = {block[0], 0.3};
  view.linear[plane.v] = {block[1], -0.2};
  view.linear[static_cast<int>(axis)] = {0.1, 0.2, lattice.scale};
  return view;
}

inline Footprint footprint_of(const Lattice& lattice, double radius = 1.6) {
  return make_footprint(view_of(lattice), Axis::z, radius);
}

/// Q straight from its definition.
inline double direct_q(const Footprint& footprint, glm::dvec2 from_centre) {
  const auto r = footprint.p * from_centre;
  return 1 - (r.x * r.x + r.y * r.y);
}

inline double quartic(double q) { return q > 0 ? q * q : 0; }

/// A splat and the centre it was made from.
struct Placed {
  Splat splat;
  double x, y;
};

struct Material {
  float red, green, blue, opacity;
};

/// As it arrives at a Renderer.
inline VoxelColour sent(const Material& material) {
  PackedVoxel voxel;
  pack(&material.red, 1, &voxel);
  return unpack(voxel);
}

inline Placed place(const Footprint& footprint, double x, double y, const Material& material) {
  return {make_splat(footprint, anchor(x, y), sent(material)), x, y};
}

/// `painter`: a RegionPainter or a SplatSum.
template <class Painter>
DrawCounts draw_all(Painter& painter, const std::vector<Placed>& splats) {
  std::vector<Splat> all;
  for (const auto& placed : splats) all.push_back(placed.splat);
  return painter.draw(all);
}

/// Splats at random over [x0, x1) × [y0, y1), with their kernels' weights.
inline std::vector<Placed> random_splats(const Footprint& footprint, int count, double x0, double y0,
                                         double x1, double y1, unsigned seed, float opacity = 0.2F) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(x0, x1), y(y0, y1);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Placed> splats;
  for (int i = 0; i < count; ++i) {
    const double at_x = x(random), at_y = y(random);
    const Material material{unit(random), unit(random), unit(random), opacity * unit(random)};
    splats.push_back(place(footprint, at_x, at_y, material));
  }
  return splats;
}

/// `painter`: a RegionPainter or a RegionImage.
template <class Painter>
std::vector<float> tile_of(const Painter& painter, int width, int height) {
  std::vector<float> tile(std::size_t(4) * std::size_t(width) * std::size_t(height));
  painter.read_tile(tile);
  return tile;
}

inline bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace ringsplat::test

#include "view/slice_plane.hpp"

#include <fmt/format.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr double largest_side = 1 << 20;

double to_multiple(double value, double unit) { return std::nearbyint(value / unit) * unit; }

/// Pixels a voxel along an axis whose voxels are `screen_pixels` apart on the screen.
double sampling(double screen_pixels, double samples, double least) {
  while (samples > 1 && samples > screen_pixels) samples = samples > 2 ? 0.5 * samples : 1;
  if (samples <= std::max(screen_pixels, least)) return samples;
  // Rounded up to a number whose products with voxel indices are exact.
  const double unit = std::exp2(std::floor(std::log2(screen_pixels)) - 10);
  return std::ceil(screen_pixels / unit) * unit;
}

struct Scaled {
  glm::dvec2 pixels_a_voxel;
  glm::dmat2 from_screen;  ///< to the plane's pixels
};

Scaled scale(const ViewTransform& view, Axis axis, double samples, double least) {
  const auto [u, v] = in_plane(axis);
  const glm::dmat2 block(glm::dvec2(view.linear[u]), glm::dvec2(view.linear[v]));
  const glm::dvec2 pixels{sampling(glm::length(block[0]), samples, least),
                          sampling(glm::length(block[1]), samples, least)};
  return {pixels, glm::dmat2(pixels.x, 0, 0, pixels.y) * glm::inverse(block)};
}

struct Box {
  glm::dvec2 low{INFINITY}, high{-INFINITY};
  void include(const glm::dvec2& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
};

}  // namespace

double plane_density(const ViewTransform& view, Axis axis, double samples, double least) {
  return std::abs(glm::determinant(scale(view, axis, samples, least).from_screen));
}

SlicePlane make_slice_plane(const ViewTransform& view, Axis axis, const glm::ivec3& dims, double samples,
                            double radius, int width, int height, double least) {
  const auto [u, v] = in_plane(axis);
  const int k = static_cast<int>(axis);
  SlicePlane plane;
  const auto [pixels_a_voxel, from_screen] = scale(view, axis, samples, least);
  const glm::dvec2 exact_shear = from_screen * glm::dvec2(view.linear[k]);
  constexpr double unit = 1.0 / (1 << 30);
  const glm::dvec2 shear{to_multiple(exact_shear.x, unit), to_multiple(exact_shear.y, unit)};

  plane.warp = {from_screen, -(from_screen * glm::dvec2(view.offset))};
  // A kernel is never narrower than a pixel, and its window ends within the pixel after that.
  const glm::dvec2 reach = glm::max(radius * pixels_a_voxel, glm::dvec2(1.0)) + 1.0;
  Box slices, screen;  // kernels included
  for (const double slice : {0.0, double(dims[k] - 1)}) {
    slices.include(shear * slice - reach);
    slices.include(shear * slice + pixels_a_voxel * (glm::dvec2(dims[u], dims[v]) - 1.0) + reach);
  }
  for (const double x : {0.0, double(width)})
    for (const double y : {0.0, double(height)}) screen.include(plane.warp.from_screen({x, y}));
  const glm::dvec2 low = glm::floor(glm::max(slices.low, screen.low)) - double(SlicePlane::border);
  const glm::dvec2 size = glm::max(
      glm::ceil(glm::min(slices.high, screen.high)) + double(SlicePlane::border) - low, glm::dvec2(1.0));
  if (!(std::max(size.x, size.y) <= largest_side))
    throw InputError(
        fmt::format("the image in the slices' plane would be {:.3g} x {:.3g} pixels", size.x, size.y),
        "use --image-plane screen for this view, or check the volume's spacing");
  plane.width = static_cast<int>(size.x);
  plane.height = static_cast<int>(size.y);
  // Voxels of slice 0 lie on pixel centres.
  const glm::dvec2 offset = 0.5 - low;
  plane.warp.offset += offset;
  plane.view = view;
  plane.view.linear[u] = {pixels_a_voxel.x, 0.0, view.linear[u].z};
  plane.view.linear[v] = {0.0, pixels_a_voxel.y, view.linear[v].z};
  plane.view.linear[k] = {shear, view.linear[k].z};
  plane.view.offset = {offset, view.offset.z};
  return plane;
}

}  // namespace ringsplat

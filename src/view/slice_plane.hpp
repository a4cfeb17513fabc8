#pragma once
#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>

#include "ringsplat/view/view.hpp"

namespace ringsplat {

/// Maps screen pixels' centres to places in the intermediate image, both in pixels: linear · (x, y) + offset.
struct PlaneWarp {
  glm::dmat2 linear{1.0};
  glm::dvec2 offset{0.0};
  glm::dvec2 from_screen(glm::dvec2 pixel) const { return linear * pixel + offset; }
};

/// An image in the plane of the slices, onto which all of them are sheared along the rays (Lacroute and Levoy
/// 1994). Within a slice every voxel has the same place among the pixels, so the image costs a few pixels a
/// voxel whatever the picture's size. One warp then turns it into the picture.
struct SlicePlane {
  ViewTransform view;  ///< lattice to the image's pixels; depth and world directions are the screen's
  PlaneWarp warp;
  int width = 1,
      height = 1;  ///< what the screen shows of the slices, with `border` pixels round it that stay empty
  /// The warp reads four pixels along each axis. If a slice reaches one of them, all four are in the image.
  static constexpr int border = 3;
};

/// Pixels of the plane for each pixel of the screen; `samples` and `least` as in make_slice_plane().
double plane_density(const ViewTransform& view, Axis axis, double samples, double least);

/// `view`: of the lattice to a screen of width × height pixels. `samples`: pixels a voxel along either axis
/// of the slices. Where the screen has fewer it is halved, or, below 1, made the screen's, so
/// that the warp never skips pixels; but never made less than `least`. `radius`: of the kernels, in voxels.
///
/// The shear is rounded to 2⁻³⁰ pixels a slice. Positions are then exact in double precision; where the plane
/// has a whole number of pixels a voxel, a slice's voxels are exactly whole pixels apart. The rounding moves
/// the last of a thousand slices by less than 10⁻⁶ pixels. Throws InputError when the image would be larger
/// than 2^20 pixels a side.
SlicePlane make_slice_plane(const ViewTransform& view, Axis axis, const glm::ivec3& dims, double samples,
                            double radius, int width, int height, double least = 0);

}  // namespace ringsplat

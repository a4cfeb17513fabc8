#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "splat/footprint.hpp"

namespace ringsplat {

/// The sum of all kernels of an endless slice, each times Footprint::weight, as a function of the place in
/// the lattice: about 1, and the same in every cell because the view is affine.
///
/// Its reciprocal is tabled over one cell and interpolated linearly. The table's steps are 1/512 of the
/// kernel's half width along each axis, which bounds the interpolation's error at 1.2e-5 of the sum (the
/// second derivatives of all kernels at a place are 12 / half width² together at most); found are 8e-6.
///
/// Where voxels lie a whole number of pixels apart, as in an image in the slices' plane, the sum takes few
/// values in a slice. There is no table then: the values are computed for each row.
class LatticeSum {
 public:
  /// `to_pixels`: from lattice (u, v). Filling the table costs half a million evaluations of Q², whatever the
  /// view.
  LatticeSum(const Footprint& footprint, const glm::dmat2& to_pixels);

  /// The sum itself at `lattice`, in double precision. For kernels more than 64 voxels wide it takes
  /// every m-th voxel m times, which changes the sum by less than 1e-6.
  double exact(glm::dvec2 lattice) const;

  /// Divides `count` RGBA pixels of a row, from pixel (x, y) of the image plane on, by the sum at their
  /// centres. `voxel`: position of any voxel of the slice, in pixels.
  void divide_row(float* rgba, std::size_t count, std::int64_t x, std::int64_t y, glm::dvec2 voxel) const;

  /// The factors by which divide_row multiplies four pixels from (x, y) on, each factor once a channel. Only
  /// for voxels a whole number of pixels apart, as in an AlignedSlice: the row's other pixels repeat these,
  /// and so do every fourth row's.
  void fill_factors(std::int64_t x, std::int64_t y, glm::dvec2 voxel, float (&factors)[16]) const;

 private:
  int phases_x_ = 0, phases_y_ = 0;  ///< pixels from voxel to voxel if these are whole numbers, else 0
  glm::dmat2 to_lattice_{1.0};       ///< from pixels
  glm::dmat2 form_{1.0};             ///< lattice offsets to kernel radii: Q = 1 − |form · offset|²
  double weight_ = 1;                ///< of each kernel that is counted
  glm::dvec2 reach_{1.0};            ///< lattice offsets beyond which Q is not positive
  glm::dvec2 stride_{1.0};           ///< voxels from one that is counted to the next
  int width_ = 1, height_ = 1;       ///< steps a cell along u and v
  std::vector<float> table_;         ///< [height + 1][width + 1]; the last row and column repeat the first
};

}  // namespace ringsplat

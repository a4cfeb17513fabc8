#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "ringsplat/view/view.hpp"

namespace ringsplat {

/// Screen positions of a slice set's voxels by digital differential analysis: three additions a voxel after
/// set-up (Neumann 1992, section 3).
///
/// The steps along a row are the same for all rows, so they are summed once a frame, each as a product
/// rounded once. Unlike a running sum, a position does not drift with the row's length, and positions can be
/// read in any order. Each is within 2⁻⁵³ · (|n · step| + |position|) of row start + n · step.
class SliceDda {
 public:
  /// `width`: voxels in a row of the set's slices.
  SliceDda(const ViewTransform& view, Axis axis, int width) : view_(view), axis_(axis) {
    const glm::dvec3 step = view.linear[in_plane(axis).u];
    for (int k = 0; k < 3; ++k) {
      steps_[std::size_t(k)].resize(std::size_t(width));
      for (int u = 0; u < width; ++u) steps_[std::size_t(k)][std::size_t(u)] = step[k] * double(u);
    }
  }
  /// Goes to lattice (u, v, axis) = (0, row, slice), with u and v as in in_plane(axis).
  void begin_row(int slice, int row) {
    glm::dvec3 first{0.0};
    first[in_plane(axis_).v] = row;
    first[int(axis_)] = slice;
    row_start_ = view_.project(first);
  }
  glm::dvec3 position(std::uint32_t column) const {
    return row_start_ + glm::dvec3(steps_[0][column], steps_[1][column], steps_[2][column]);
  }

  // x and y are row start + step.
  const glm::dvec3& row_start() const { return row_start_; }
  const double* steps_x() const { return steps_[0].data(); }
  const double* steps_y() const { return steps_[1].data(); }

 private:
  ViewTransform view_;
  Axis axis_;
  std::array<std::vector<double>, 3> steps_;  ///< by screen axis and column
  glm::dvec3 row_start_{0.0};
};

}  // namespace ringsplat

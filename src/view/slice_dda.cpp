#include "view/slice_dda.hpp"

namespace ringsplat {

SliceDda::SliceDda(const ViewTransform& view, Axis axis, int width) : view_(view), axis_(axis) {
  const glm::dvec3 step = view.linear[in_plane(axis).u];
  for (int k = 0; k < 3; ++k) {
    steps_[std::size_t(k)].resize(std::size_t(width + padding));
    for (int u = 0; u < width; ++u) steps_[std::size_t(k)][std::size_t(u)] = step[k] * double(u);
  }
}

void SliceDda::begin_row(int slice, int row) {
  glm::dvec3 first{0.0};
  first[in_plane(axis_).v] = row;
  first[int(axis_)] = slice;
  row_start_ = view_.project(first);
}

}  // namespace ringsplat

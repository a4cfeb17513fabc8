#include "ringsplat/view/slice_dda.hpp"

namespace ringsplat {

SliceDda::SliceDda(const ViewTransform& view, Axis axis, int width)
    : view_(view), axis_(axis), columns_(std::size_t(width)) {
  const glm::dvec3 step = view.linear[in_plane(axis).u];
  for (std::size_t u = 0; u < columns_.size(); ++u) columns_[u] = step * double(u);
}

void SliceDda::begin_row(int slice, int row) {
  glm::dvec3 first{0.0};
  first[in_plane(axis_).v] = row;
  first[int(axis_)] = slice;
  row_start_ = view_.project(first);
}

}  // namespace ringsplat

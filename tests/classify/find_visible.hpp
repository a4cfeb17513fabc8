#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "classify/classifier.hpp"

namespace ringsplat {

/// The visible voxels of a row of `columns` scalars.
inline VisibleRow find_visible(const Classifier& classifier, const std::byte* row, int columns) {
  std::vector<std::uint64_t> masks(masks_of(columns), 0);
  classifier.find_row(row, 0, columns, masks.data());
  VisibleRow visible;
  visible.take(masks, 0, std::uint32_t(columns));
  return visible;
}

}  // namespace ringsplat

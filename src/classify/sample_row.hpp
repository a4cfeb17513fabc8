#pragma once
#include <cstddef>

#include "classify/classifier.hpp"
#include "classify/phong.hpp"

namespace ringsplat {

/// A row of a slice.
struct VoxelRow {
  const std::byte* values;    ///< in native byte order, at any address
  const NormalCode* normals;  ///< may be null
  int columns;
};

/// Makes the samples of the visible voxels that classifier.find_row found in a row. Each is lit by its
/// normal, or unlit if `phong` or the normals are null. The same bits at every vector width.
void make_samples(const Classifier& classifier, const VoxelRow& row, const PhongTable* phong,
                  VisibleRow& out);

}  // namespace ringsplat

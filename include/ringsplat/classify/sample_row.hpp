#pragma once
#include <cstddef>

#include "ringsplat/classify/classifier.hpp"
#include "ringsplat/classify/phong.hpp"

namespace ringsplat {

/// Makes the samples of the visible voxels that classifier.find_row found in a row of scalars, each lit by
/// its own of the row's normals; unlit where `phong` or `normals` is null. The same bits at every vector
/// width.
void make_samples(const Classifier& classifier, const std::byte* row, const PhongTable* phong,
                  const NormalCode* normals, VisibleRow& out);

}  // namespace ringsplat

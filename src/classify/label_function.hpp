#pragma once
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// Opacity of a voxel with a label.
inline constexpr double label_opacity = 0.9;

/// A transfer function in which each of `labels` (whole numbers, ascending) has a colour of its own and
/// nearly full opacity, up to half-way to the next whole numbers; 0 and numbers that are no label are clear.
///
/// A label's colour depends on its number alone, so that it is the same in every volume.
TransferFunction label_function(const std::vector<double>& labels);

/// The display colour of a label.
glm::dvec3 label_colour(double label);

}  // namespace ringsplat

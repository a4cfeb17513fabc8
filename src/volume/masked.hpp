#pragma once
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "ringsplat/volume/source.hpp"

namespace ringsplat {

/// Which labels of a segmentation to show: from the first to the second of a pair, both included; none: all
/// but 0.
using LabelRanges = std::vector<std::pair<std::int64_t, std::int64_t>>;

/// The volume where `segmentation` has one of these labels, and elsewhere the value of voxels without data:
/// the file's, not-a-number, air's in Hounsfield units, or 0. The segmentation may have another grid: a
/// voxel's label is that of the nearest voxel there in world coordinates, and none beyond its voxels. One of
/// as many voxels in coordinates of another kind, or in the lattice's, is taken voxel by voxel; else
/// InputError.
std::unique_ptr<VolumeSource> masked_source(std::unique_ptr<VolumeSource> volume,
                                            std::unique_ptr<VolumeSource> segmentation, LabelRanges labels);

}  // namespace ringsplat

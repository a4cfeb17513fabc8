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

/// What stands for a label among 1 to most_tints, from which on they begin again.
std::uint8_t label_byte(double label);

/// What a segmentation does to the volume that it covers.
enum class Covered {
  alone,    ///< only that is shown: elsewhere is the value of voxels without data, which is the file's,
            ///< not-a-number, air's in Hounsfield units, or 0
  tinted,   ///< labels() tells the labels
  outlined  ///< labels() tells those of voxels with a neighbour of another label along an axis
};

/// The volume with a segmentation over it, of which these labels count. The segmentation may have another
/// grid: a voxel's label is that of the nearest voxel there in world coordinates, and none beyond its voxels.
/// One of as many voxels in coordinates of another kind, or in the lattice's, is taken voxel by voxel; else
/// InputError.
std::unique_ptr<VolumeSource> segmented_source(std::unique_ptr<VolumeSource> volume,
                                               std::unique_ptr<VolumeSource> segmentation, LabelRanges labels,
                                               Covered covered = Covered::alone);

}  // namespace ringsplat

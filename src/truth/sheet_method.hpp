#pragma once
#include <span>
#include <vector>

#include "truth/scene.hpp"

namespace ringsplat::truth {

/// The algorithm of sheets itself, without the renderer's arithmetic: no tables, every slab integrated
/// exactly, nothing left out or stopped early. Scene::sheets must have a value; InputError when its numbers
/// make no sense. All cores.
///
/// A pixel's ray meets q sheets a slice of the set that it crosses most, at i + j/q slices, with
/// q = Traversal::slabs_for(slabs); the first is slice 0, the last slice n − 1. Two more, at −½ and n − ½,
/// are the box's faces, so the outermost slabs are half a slice thick, unless there are more of them
/// (slabs_in_half). On a sheet the value and the central differences of the voxels (one-sided at the border)
/// are trilinear at the ray's place, which is first moved into [0, n − 1] along each axis. Where a voxel of
/// the cell is not a number, the sheet's value is none, and the slabs on both sides are transparent. On a
/// sheet in a slice only that slice counts.
///
/// Between two sheets the value is linear: integrate_slab() gives opacity, colour, centroid t and spread d.
/// Where the ray enters or leaves the box through its sides, only part p of a slab lies inside: its
/// opacity becomes 1 − (1 − a)^p, while colour, t and d stay the whole slab's. The light of a slab is taken
/// at t, or is the mean of that at t − d and at t + d (moved into [0, 1]), with gradients interpolated
/// linearly from one sheet to the other. The image plane is no part of this: the picture of sheets in the
/// slices' plane has its warp as an error.
///
/// Where Scene::nearest is set, q is rounded up to an even number and the outermost half slices have q/2
/// slabs. Both sheets of a slab then have the value of the voxel that is nearest to the middle between them.
std::vector<Rgba> sheet_method_truth(const Scene& scene, std::span<const Pixel> pixels);

}  // namespace ringsplat::truth

#pragma once
#include <span>
#include <vector>

#include "truth/field.hpp"
#include "truth/scene.hpp"

namespace ringsplat::truth {

/// The splatting model itself, without the renderer's arithmetic.
///
/// Each voxel is classified, shaded, and corrected to 1 − (1 − α)^d for d unit lengths between slices along
/// the ray. Its kernel is Q², Q = 1 − r², r in kernel radii (Neumann 1992, section 2.2; at least a pixel from
/// the centre), multiplied by 3/(π T²) or its widened equivalent, so that weights average to one. Each
/// slice of the set most parallel to the view plane is summed at the pixel's centre, clamped (opacity a to
/// [0, 1], colour to [0, a]) and composited front to back.
///
/// Cost: slices × voxels under one kernel a pixel, plus one classification a voxel; all cores.
std::vector<Rgba> splat_method_truth(const Scene& scene, std::span<const Pixel> pixels);

/// The pixels that a voxel's kernel may reach. At all others this truth is transparent.
ScreenBounds splat_method_bounds(const Scene& scene);

/// The algorithm of sheets itself, without the renderer's arithmetic: no tables, every slab integrated
/// exactly, nothing left out or stopped early. All cores.
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
/// From slice to slice the field along a ray bends, so where q > 1 both ends are first moved by what the
/// parabolas through a slab's sheets and the next ones are on average beside the line, -D/12 of the second
/// differences D at both ends (at the slices: of the other end), but not beyond the values of the q + 1
/// sheets; not where one of these is none.
/// Where the ray enters or leaves the box through its sides, only part p of a slab lies inside: its
/// opacity becomes 1 − (1 − a)^p, while colour, t and d stay the whole slab's. The light of a slab is taken
/// at t, or is the mean of that at t − d and at t + d (moved into [0, 1]), with gradients interpolated
/// linearly from one sheet to the other. The image plane is no part of this: the picture of sheets in the
/// slices' plane has its warp as an error.
///
/// Where values are the nearest voxel's, q is rounded up to an even number and the outermost half slices have
/// q/2 slabs. Each slab is cut at the voxels' faces, where the value changes; t and d are then a part's place
/// in the slab.
std::vector<Rgba> sheet_method_truth(const Scene& scene, std::span<const Pixel> pixels);

/// What the frame's method draws, without the renderer's arithmetic: the truth of splats or of sheets, which
/// are exact in all modes but compositing, of which depths are the field's.
inline std::vector<Rgba> method_truth(const Scene& scene, std::span<const Pixel> pixels) {
  if (scene.frame.shown.mode != Mode::composite || scene.frame.shown.values)
    return field_truth(scene, pixels);
  return scene.of_sheets() ? sheet_method_truth(scene, pixels) : splat_method_truth(scene, pixels);
}

/// Outside of these pixels that truth is transparent.
inline ScreenBounds method_bounds(const Scene& scene) {
  return scene.of_sheets() ? field_bounds(scene) : splat_method_bounds(scene);
}

}  // namespace ringsplat::truth

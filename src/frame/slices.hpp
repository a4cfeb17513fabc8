#pragma once
#include <vector>

#include "ringsplat/frame/frame_spec.hpp"

/// Frames of single slices: of a volume's, and of the one that closes a volume which is cut open.
namespace ringsplat {

/// How far before a plane a place of the lattice is, in world lengths.
double before(const ClipPlane& plane, const Grid& grid, const glm::dvec3& place);

/// The plane through a place of the lattice across a world direction of unit length, and along an axis'
/// slices.
ClipPlane plane_across(const Grid& grid, const glm::dvec3& direction, const glm::dvec3& place);
ClipPlane plane_along_slices(const Grid& grid, Axis axis, const glm::dvec3& place);

/// Clip planes that leave of a volume what lies in another plane: within a thousandth of a voxel of it, or,
/// of large volumes, as near as positions along rays are exact.
std::vector<ClipPlane> planes_of_slice(const ClipPlane& plane, const Grid& grid);
/// A volume that is cut open has no more clip planes of its own: its slice needs two.
inline constexpr std::size_t most_clip_planes_of_cut = Shown::most_clip_planes - 2;

/// Has a frame of one slice show its values, opaque and unlit, in the transfer function's colours; labels but
/// for clear ones.
void show_values(Shown& shown);

/// What shows a volume that Shown::cut cuts open: a frame of what is left of it, as the view is, and one of
/// the slice that lies over it.
struct CutOpen {
  FrameSpec left, slice;
};
CutOpen cut_open(const FrameSpec& spec, const Grid& grid);

}  // namespace ringsplat

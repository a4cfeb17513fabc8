#pragma once
#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/view/view.hpp"
#include "screen/regions.hpp"
#include "view/slice_plane.hpp"

namespace ringsplat {

/// A clip plane among voxels.
struct LatticePlane {
  glm::dvec3 normal;  ///< unit length
  double offset;
  /// How far before it a place is, in voxels: what is left is at least 0.
  double before(const glm::dvec3& place) const { return glm::dot(normal, place) + offset; }
};

/// Layers of slices that are drawn each for itself (Sheets::layers). Each has an image plane of its own; they
/// lie one below another in one tall plane, whose regions Renderers draw.
struct Layers {
  int slices = 0;  ///< of a layer; 0: there are none
  int count = 1;
  int height = 0;  ///< pixels from a layer's plane to the next one's
  /// Of one plane, into which the layers' regions are composited, and the block of those that voxels reach.
  Regions picture;
  PixelRect reached;
};

/// What follows from a FrameSpec and a volume's grid; the same on every rank.
struct FrameGeometry {
  Grid grid;           ///< of what is rendered: reduced when undersampled, and the part in `box`
  VoxelBox box;        ///< that part of the (reduced) volume's slices
  ViewTransform view;  ///< from that grid's lattice to the image plane
  std::vector<LatticePlane> clip_planes;  ///< in that lattice
  Traversal traversal;
  /// Reach of a voxel's footprint from its centre, in pixels of the image plane; of the nearest voxel in a
  /// perspective view, and infinite when a corner of the box is beside or behind the eye.
  glm::dvec2 reach{0.0};
  int width = 0, height = 0;  ///< of the image plane, in pixels
  Layers layers;
  Regions regions;                ///< of the image plane, or of those of all layers
  PixelRect reached;              ///< block of regions that voxels can reach, in region columns and rows
  bool in_parts = false;          ///< each Renderer gets neighbouring regions
  int dealt_to = 0;               ///< how many Renderers get regions; 0: all
  std::vector<int> dealt;         ///< by region, its Renderer; empty: dealt in turn
  int slices = 0;                 ///< in the traversed set
  std::optional<PlaneWarp> warp;  ///< from the screen to the image plane, when they differ

  const Regions& picture_regions() const { return layers.slices > 0 ? layers.picture : regions; }
  /// The slice of a step of the traversal.
  int slice_at(int step) const { return traversal.slice_at(step, slices); }
  int layer_of(int slice) const { return layers.slices > 0 ? slice / layers.slices : 0; }
  /// Where pixels of the image plane are in a layer's; outside of all regions where none are.
  PixelWindow in_layer(const PixelWindow& pixels, int layer) const {
    if (layers.slices == 0) return pixels;
    const std::int64_t y0 = std::max<std::int64_t>(pixels.y0, 0),
                       y1 = std::min<std::int64_t>(pixels.y1, height - 1);
    if (y0 > y1) return {-1, -1, -1, -1};
    return {pixels.x0, y0 + layer * layers.height, pixels.x1, y1 + layer * layers.height};
  }

  /// Owners, by region of the picture, where there are layers: who composites what others have drawn there.
  std::vector<int> tile_owners(int renderers) const;
  /// Who draws the reached regions, by region, among `renderers` Renderers: as `dealt` says, or in turn. In
  /// Neumann 1992 (section 3) a Renderer has one region.
  std::vector<int> owners(int renderers) const;
};

/// World lengths from the volume's middle to a place of its lattice.
inline glm::dvec3 from_middle(const Grid& grid, const glm::dvec3& place) {
  return grid.direction * (grid.spacing * (place - 0.5 * glm::dvec3(grid.dims - 1)));
}

inline LatticeFrame lattice_frame(const Grid& grid) {
  return {grid.dims, grid.spacing, grid.origin, grid.direction};
}

/// The axis of the slice set that a frame of the volume traverses. Throws InputError when it can traverse
/// none, or its clip box is none of the volume's.
Axis traversed_axis(const FrameSpec& spec, const Grid& grid);
/// Throws InputError when a view cannot be drawn by the frame's method, or the clip box is none of the
/// volume's.
FrameGeometry make_geometry(const FrameSpec& spec, const Grid& grid);

/// Sets the regions of a geometry that is otherwise complete, and which of them voxels can reach. The
/// picture's bits do not depend on it.
void lay_regions(FrameGeometry& geometry, const FrameSpec& spec);

/// The regions that the volume's voxels can reach, in columns and rows of regions.
PixelRect reached_regions(const FrameGeometry& geometry, const Regions& regions);

}  // namespace ringsplat

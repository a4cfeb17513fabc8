#pragma once

namespace ringsplat {

/// The rays of a perspective view. Vectors are in voxels along u, v and k, the traversed axis; slices count
/// from the middle one.
///
/// They are counted from the central ray, which goes through the middle of the volume, so that floats lose
/// nothing to a far eye: pixel (x, y) has the slope central_slope[i] + d[i], with
///   d[i] = (slope_x[i] (x - central_x) + slope_y[i] (y - central_y)) / depth,
///   depth = 1 + depth_x (x - central_x) + depth_y (y - central_y),
/// and meets the middle slice at central_middle[i] + to_middle d[i].
struct EyeGrid {
  float central_x = 0, central_y = 0;  ///< the pixel of the central ray; centres of pixels are whole numbers
  float central_slope[2] = {}, central_middle[2] = {};
  float slope_x[2] = {}, slope_y[2] = {}, depth_x = 0, depth_y = 0;
  float to_middle = 0;     ///< from the eye to the middle slice, along k
  float way = 1;           ///< the sign of k along the rays
  float half_slices = 0;   ///< from the middle to the volume's faces
  float steepest[2] = {};  ///< rays that move by more along u or v from slice to slice miss the volume
  float low[2] = {}, high[2] = {};  ///< rays that meet the middle slice outside miss the volume
  float axes[3][3] = {};            ///< from (u, v, k) to GradientLight's coordinates, of world lengths
  float table_length = 0;  ///< the way from slice to slice that slabs are made for; 0: each ray's own

  /// What positions and bounds of them may be wrong by, in voxels.
  static constexpr float position_error = 1.0F / 256;

  /// Depth and slopes at a pixel, in double precision.
  double depth(double x, double y) const;
  double slope(int i, double x, double y) const;

  /// Whether tiles of `tile` x `tile` pixels, within `side` x `side` pixels from (x, y) on, span less than
  /// `voxels` in every slab.
  bool spans_less(int x, int y, int side, int tile, double voxels) const;
};

}  // namespace ringsplat

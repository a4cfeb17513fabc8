#pragma once
#include <optional>

#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/statistics.hpp"

namespace ringsplat::serve {

/// What lies under a pixel.
struct Probed {
  bool hit = false;
  glm::dvec3 voxel{0.0};  ///< lattice coordinates
  glm::dvec3 world{0.0};
  double value = 0;
};

/// The camera whose picture of 1 x 1 pixel shows, along the same ray, what (x, y) of a picture of `camera`
/// shows.
Camera camera_of_pixel(const Camera& camera, int width, int height, double x, double y);

/// Finds the first opaque point of a pixel's ray by frames of one pixel, so that no rank needs to know of it:
/// the ranks draw the volume cut off behind ever fewer slices, and the fewest through which the ray becomes
/// half as opaque as it is in the end lie before the point. Two more frames, whose colours stand for values,
/// read the slice there. In modes without light the place is where the extremum is reached.
class Probe {
 public:
  /// `full`: the view's frame at its best level. (x, y): in pixels, from the corner. Throws InputError when
  /// the ranks would refuse the ray's frame.
  Probe(const FrameSpec& full, const Grid& grid, const ValueRange& range, double x, double y);

  /// The values of the volume that is read, when it became known after the view.
  void know_range(const ValueRange& range);
  /// The next frame to draw; nothing when the answer is there.
  const std::optional<FrameSpec>& next_frame() const { return next_; }
  /// Takes the frame's picture.
  void take(const Image& picture);
  const Probed& answer() const { return answer_; }

 private:
  enum class Stage { whole, place, value, value_again };
  int middle() const { return (low_ + high_) / 2; }
  bool looks_for_extremum() const;
  float reached(const float* rgba) const;
  double value_of(double red) const;
  VoxelBox front_slices(int count) const;
  void choose_place();
  void ask_for_values(double low, double high);
  void read(double red);

  Grid grid_;
  ValueRange range_;
  std::optional<FrameSpec> next_;
  VoxelBox box_;  ///< the part that is shown
  int axis_;
  bool ascending_;
  Stage stage_ = Stage::whole;
  int low_ = 0, high_ = 0;  ///< slices: too few, enough
  float low_opacity_ = 0, high_opacity_ = 0;
  float wanted_ = 0;                       ///< opacity
  double value_low_ = 0, value_high_ = 0;  ///< that black and white stand for
  Probed answer_;
};

}  // namespace ringsplat::serve

#pragma once
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <optional>

#include "frame/frame_geometry.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "serve/client_message.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::serve {

/// What lies under a pixel.
struct Probed {
  bool hit = false;
  glm::dvec3 voxel{0.0};  ///< lattice coordinates
  glm::dvec3 world{0.0};
  double value = 0;
};

/// The camera whose picture of 1 x 1 pixel shows, along the same ray, what a picture of `camera` shows at (x,
/// y), in pixels from its corner.
inline Camera camera_of_pixel(const Camera& camera, const LatticeFrame& lattice, int width, int height,
                              double x, double y) {
  const double side = std::min(width, height);
  const auto scale = [&](int w, int h) { return make_view(camera, lattice, w, h).pixels_per_unit; };
  Camera pixel = camera;
  pixel.zoom = camera.zoom * scale(width, height) / scale(1, 1);
  pixel.pan = {0.5 * width + camera.pan[0] * side - x, 0.5 * height + camera.pan[1] * side - y};
  return pixel;
}

/// Finds the first opaque point of a pixel's ray by frames of one pixel, so that no rank needs to know of it:
/// the ranks draw the volume cut off behind ever fewer slices, and the fewest through which the ray becomes
/// half as opaque as it is in the end lie before the point. One more frame, of numbers, reads the value
/// there. In modes without light the place is where the extremum is reached.
class Probe {
 public:
  /// `full`: the view's frame at its best level. (x, y): in pixels, from the corner. Throws InputError when
  /// the ranks would refuse the ray's frame.
  Probe(const FrameSpec& full, const Grid& grid, double x, double y)
      : grid_(grid), next_(full), box_(full.shown.clip.value_or(whole_box(grid))) {
    Shown& shown = next_->shown;
    shown.camera = camera_of_pixel(shown.camera, lattice_frame(grid), shown.width, shown.height, x, y);
    shown.width = shown.height = 1;
    shown.shading = Shading::none;
    for (Tint& tint : shown.tints) tint.share = 0;  // greys tell of values
    if (looks_for_extremum() && shown.mode != Mode::minip) shown.mode = Mode::mip;
    check_frame(*next_, grid);
    const Traversal traversal = make_geometry(*next_, grid).traversal;
    axis_ = static_cast<int>(traversal.axis);
    ascending_ = traversal.ascending;
    high_ = box_.end[axis_] - box_.first[axis_];
  }

  /// Of a voxel.
  Probe(const FrameSpec& full, const Grid& grid, const glm::ivec3& voxel)
      : grid_(grid), next_(full), box_(whole_box(grid)), axis_(static_cast<int>(Axis::z)) {
    next_->shown.width = next_->shown.height = 1;
    next_->shown.shading = Shading::none;
    found(voxel);
    read(voxel, voxel.z);
  }

  /// The values of the volume that is read: needed before the first frame.
  void know_range(const ValueRange& range) {
    range_ = range;
    if (looks_for_extremum()) show_range();
  }
  /// The next frame to draw; nothing when the answer is there.
  const std::optional<FrameSpec>& next_frame() const { return next_; }
  void take(const Image& picture) {
    const float* const rgba = picture.pixel(0, 0);
    switch (stage_) {
      case Stage::whole:
        high_opacity_ = reached(rgba);
        wanted_ = (looks_for_extremum() ? 0.999F : 0.5F) * high_opacity_;
        if (rgba[3] < least_opacity) return next_.reset();
        stage_ = Stage::place;
        break;
      case Stage::place: {
        const float so_far = reached(rgba);
        const bool enough = so_far >= wanted_;
        (enough ? high_ : low_) = middle();
        (enough ? high_opacity_ : low_opacity_) = so_far;
        break;
      }
      case Stage::value:
        answer_.value = rgba[0];
        return next_.reset();
    }
    if (high_ - low_ <= 1) return choose_place();
    VoxelBox& front = next_->shown.clip.emplace(box_);
    if (ascending_)
      front.end[axis_] = box_.first[axis_] + middle();
    else
      front.first[axis_] = box_.end[axis_] - middle();
  }
  const Probed& answer() const { return answer_; }

 private:
  enum class Stage { whole, place, value };
  /// Less opaque a ray hits nothing.
  static constexpr float least_opacity = 1.0F / 32;

  int middle() const { return (low_ + high_) / 2; }
  /// Where rays take no light, the value is found that decides on the pixel, of means and integrals the
  /// largest.
  bool looks_for_extremum() const {
    return next_->shown.mode != Mode::composite && next_->shown.mode != Mode::surface;
  }
  float reached(const float* rgba) const {
    if (!looks_for_extremum()) return rgba[3];
    return next_->shown.mode == Mode::minip ? 1 - rgba[0] : rgba[0];
  }

  /// Where the ray meets the plane of that coordinate, in lattice coordinates.
  glm::dvec3 meet(double at) const {
    const ViewTransform view = make_view(next_->shown.camera, lattice_frame(grid_), 1, 1);
    const glm::dmat3 to_lattice = glm::inverse(view.linear);
    const glm::dvec3 point = to_lattice * (glm::dvec3(0.5, 0.5, 0) - view.offset);
    const glm::dvec3 way = view.eye ? point - *view.eye : to_lattice * glm::dvec3(0, 0, 1);
    return point + way * ((at - point[axis_]) / way[axis_]);
  }

  void choose_place() {
    const double into =
        double(high_ - 1) +
        std::clamp((wanted_ - low_opacity_) / std::max(high_opacity_ - low_opacity_, 1e-6F), 0.0F, 1.0F);
    const double at = ascending_ ? box_.first[axis_] - 0.5 + into : box_.end[axis_] - 0.5 - into;
    const glm::dvec3 place = glm::clamp(meet(at), glm::dvec3(0.0), glm::dvec3(grid_.dims - 1));
    found(place);
    if (looks_for_extremum())
      next_->shown.clip = box_;
    else
      read(place, ascending_ ? box_.first[axis_] + high_ - 1 : box_.end[axis_] - high_);
  }

  /// The last frame is of numbers.
  void found(const glm::dvec3& place) {
    answer_ = {true, place, grid_.origin + grid_.direction * (grid_.spacing * place)};
    stage_ = Stage::value;
    next_->shown.values = true;
  }

  /// Has the frame tell the value at a place of the lattice, seen from straight before its slice; of labels,
  /// between which there is nothing, the nearest voxel's.
  void read(const glm::dvec3& place, int slice) {
    Shown& shown = next_->shown;
    // Interpolation rounds places in a cell down to 1/65536: that of a voxel must not be in the cell before.
    constexpr double within = 0.5 / 65536;
    const glm::dvec3 at =
        (shown.interpolation == Interpolation::nearest ? glm::round(place) : place) + within;
    const LatticeFrame lattice = lattice_frame(grid_);
    const Camera facing = facing_slices(lattice, Axis(axis_), false);
    const glm::dvec3 seen = make_view(facing, lattice, 1, 1).project(at);
    shown.camera = camera_of_pixel(facing, lattice, 1, 1, seen.x, seen.y);
    shown.clip = slice_box(grid_, axis_, slice);
    shown.clip_planes.clear();
    shown.interpolation = Interpolation::linear;
    shown.mode = Mode::mip;
    show_range();
  }

  /// Has the frame show values: black for the lowest, white for the highest, and opaque everywhere.
  void show_range() {
    double low = range_.low, high = range_.high;
    if (!(low < high)) {
      low = std::isfinite(low) ? low : 0;
      high = low + 1;
    }
    next_->shown.transfer_function = {.name = "value",
                                      .colours = {{low, glm::dvec3(0.0)}, {high, glm::dvec3(1.0)}},
                                      .opacities = {{low, 1}, {high, 1}}};
  }

  Grid grid_;
  ValueRange range_;
  std::optional<FrameSpec> next_;
  VoxelBox box_;  ///< the part that is shown
  int axis_;
  bool ascending_ = true;
  Stage stage_ = Stage::whole;
  int low_ = 0, high_ = 0;  ///< slices: too few, enough
  float low_opacity_ = 0, high_opacity_ = 0;
  float wanted_ = 0;  ///< opacity
  Probed answer_;
};

}  // namespace ringsplat::serve

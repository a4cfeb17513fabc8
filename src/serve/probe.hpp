#pragma once
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <optional>
#include <utility>

#include "frame/frame_geometry.hpp"
#include "frame/slices.hpp"
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
/// one tells how opaque the ray is in the end, one of depths where it is half as opaque, and one of numbers
/// the value there. In modes without light the place is where the extremum is reached first.
class Probe {
 public:
  /// `full`: the view's frame at its best level. (x, y): in pixels, from the corner. Throws InputError when
  /// the ranks would refuse the ray's frame.
  Probe(const FrameSpec& full, const Grid& grid, double x, double y) : grid_(grid), next_(full) {
    const auto parts = full.shown.cut ? std::optional(cut_open(full, grid)) : std::nullopt;
    if (parts) next_ = parts->left;
    Shown& shown = next_->shown;
    shown.camera = camera_of_pixel(shown.camera, lattice_frame(grid), shown.width, shown.height, x, y);
    show_one_pixel();
    if (shown.mode != Mode::composite && shown.mode != Mode::surface) {
      extreme_ = shown.mode == Mode::minip ? Mode::minip : Mode::mip;
      shown.mode = *extreme_;
      shown.values = true;
    }
    check_frame(*next_, grid);
    if (shown.mode == Mode::surface) look_for_depth(1);
    if (parts) look_at_slice(parts->slice, *full.shown.cut);
  }

  /// Of a voxel.
  Probe(const FrameSpec& full, const Grid& grid, const glm::ivec3& voxel) : grid_(grid), next_(full) {
    show_one_pixel();
    found(voxel);
  }

  /// The values of the volume that is read: needed before the first frame.
  void know_range(const ValueRange& range) {
    low_ = std::isfinite(range.low) ? range.low : 0;
    high_ = low_ < range.high ? range.high : low_ + 1;
    if (next_->shown.mode == Mode::mip || next_->shown.mode == Mode::minip) show_range();
  }
  /// The next frame to draw; nothing when the answer is there.
  const std::optional<FrameSpec>& next_frame() const { return next_; }
  void take(const Image& picture) {
    const float number = picture.pixel(0, 0)[0], opacity = picture.pixel(0, 0)[3];
    const bool clear = opacity < least_opacity;
    if (clear && (stage_ == Stage::whole || stage_ == Stage::place)) return next_.reset();
    switch (stage_) {
      case Stage::cut:
        if (!clear) return found(on_cut_);
        next_ = std::exchange(behind_, std::nullopt);
        stage_ = next_->shown.depth ? Stage::place : Stage::whole;
        return;
      case Stage::whole:
        answer_.value = number;
        return look_for_depth(opacity);
      case Stage::place:
        found(at_depth(number));
        if (extreme_) next_.reset();
        return;
      case Stage::value:
        answer_.value = opacity > 0 ? number : NAN;
        return next_.reset();
    }
  }
  const Probed& answer() const { return answer_; }

 private:
  enum class Stage { cut, whole, place, value };
  /// Less opaque a ray hits nothing.
  static constexpr float least_opacity = 1.0F / 32;

  void show_one_pixel() {
    Shown& shown = next_->shown;
    shown.width = shown.height = 1;
    shown.shading = Shading::none;
    shown.mixed = false;
    shown.cut.reset();
    shown.tints.clear();
  }

  /// The next frame tells the depth of the first surface, of half the opacity, or of where a value is that
  /// differs from the extreme one by a thousandth at most.
  void look_for_depth(float opacity) {
    stage_ = Stage::place;
    Shown& shown = next_->shown;
    shown.depth = 0.5 * double(opacity);
    if (extreme_) {
      const bool least = *extreme_ == Mode::minip;
      double near = std::lerp(answer_.value, least ? high_ : low_, 1e-3);
      if (near == answer_.value) near = least ? high_ : low_;
      shown.mode = Mode::composite;
      shown.transfer_function.opacities = {
          {low_, double(least)}, {near, double(least)}, {near, double(!least)}, {high_, double(!least)}};
    }
    next_ = depth_frame_of(*next_);
  }

  /// In lattice coordinates.
  struct Ray {
    glm::dvec3 point, way;
  };
  Ray ray(const ViewTransform& view) const {
    const glm::dmat3 to_lattice = glm::inverse(view.linear);
    const glm::dvec3 point = to_lattice * (glm::dvec3(0.5, 0.5, 0) - view.offset);
    return {point, view.eye ? point - *view.eye : to_lattice * glm::dvec3(0, 0, 1)};
  }
  ViewTransform view() const { return make_view(next_->shown.camera, lattice_frame(grid_), 1, 1); }

  /// Where the ray is so far behind the plane through the volume's middle, in world lengths.
  glm::dvec3 at_depth(double depth) const {
    const ViewTransform seen = view();
    const auto [point, way] = ray(seen);
    return point + way * (depth * seen.pixels_per_unit / (seen.linear * way).z);
  }

  /// The next frame tells whether the cut is clear where the ray meets it; then what is behind is looked at.
  void look_at_slice(const FrameSpec& slice, const ClipPlane& cut) {
    const auto [point, way] = ray(view());
    const double here = before(cut, grid_, point);
    on_cut_ = point - way * (here / (before(cut, grid_, point + way) - here));
    stage_ = Stage::cut;
    behind_ = std::exchange(next_, slice);
    next_->shown.camera = behind_->shown.camera;
    show_one_pixel();
  }

  /// The last frame tells the value there, seen from straight before its slice; of labels, between which
  /// there is nothing, the nearest voxel's.
  void found(const glm::dvec3& where) {
    const glm::dvec3 place = glm::clamp(where, glm::dvec3(0.0), glm::dvec3(grid_.dims - 1));
    answer_ = {true, place, grid_.origin + grid_.direction * (grid_.spacing * place), answer_.value};
    stage_ = Stage::value;
    Shown& shown = next_->shown;
    // Beyond the outer voxels of what is shown the field has their values.
    const VoxelBox box = shown.clip.value_or(whole_box(grid_));
    const glm::dvec3 shown_at = glm::clamp(place, glm::dvec3(box.first), glm::dvec3(box.end - 1)),
                     read = shown.interpolation == Interpolation::nearest ? glm::round(shown_at) : shown_at;
    // Interpolation rounds places in a cell down to 1/65536: that of a voxel must not be in the cell before.
    constexpr double within = 0.5 / 65536;
    const LatticeFrame lattice = lattice_frame(grid_);
    const Camera facing = facing_slices(lattice, Axis::z, false);
    const glm::dvec3 seen = make_view(facing, lattice, 1, 1).project(read + within);
    shown.camera = camera_of_pixel(facing, lattice, 1, 1, seen.x, seen.y);
    shown.clip.reset();
    shown.clip_planes.clear();
    if (read.z == std::round(read.z))
      shown.clip = slice_box(grid_, int(Axis::z), int(read.z));
    else
      shown.clip_planes = planes_of_slice(plane_along_slices(grid_, Axis::z, read), grid_);
    shown.interpolation = Interpolation::linear;
    shown.mode = Mode::mip;
    shown.values = true;
    shown.depth.reset();
    show_range();
  }

  /// Has a frame of numbers tell all values.
  void show_range() {
    next_->shown.transfer_function = {.name = "value",
                                      .colours = {{low_, glm::dvec3(0.0)}, {high_, glm::dvec3(1.0)}},
                                      .opacities = {{low_, 1}, {high_, 1}}};
  }

  Grid grid_;
  double low_ = 0, high_ = 1;  ///< of the volume's values
  std::optional<FrameSpec> next_;
  std::optional<FrameSpec> behind_;  ///< the cut
  glm::dvec3 on_cut_{0.0};
  std::optional<Mode> extreme_;  ///< that is looked for
  Stage stage_ = Stage::whole;
  Probed answer_;
};

}  // namespace ringsplat::serve

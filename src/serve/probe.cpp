#include "serve/probe.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "frame/frame_geometry.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::serve {
namespace {

/// Less opaque a ray hits nothing.
constexpr float least_opacity = 1.0F / 32;

/// Where the ray of a picture's only pixel meets the plane of that coordinate, in lattice coordinates.
glm::dvec3 meet(const ViewTransform& view, int axis, double at) {
  const glm::dmat3 to_lattice = glm::inverse(view.linear);
  const glm::dvec3 point = to_lattice * (glm::dvec3(0.5, 0.5, 0) - view.offset);
  const glm::dvec3 way = view.eye ? point - *view.eye : to_lattice * glm::dvec3(0, 0, 1);
  return point + way * ((at - point[axis]) / way[axis]);
}

/// White from `high` on, black up to `low`, and opaque everywhere; between the ends red is the value.
TransferFunction value_as_red(double low, double high) {
  return {.name = "value",
          .colours = {{low, glm::dvec3(0.0)}, {high, glm::dvec3(1.0)}},
          .opacities = {{low, 1}, {high, 1}}};
}

}  // namespace

Camera camera_of_pixel(const Camera& camera, int width, int height, double x, double y) {
  const double side = std::min(width, height);
  Camera pixel = camera;
  pixel.zoom = camera.zoom * side;
  pixel.pan = {0.5 * width + camera.pan[0] * side - (std::floor(x) + 0.5),
               0.5 * height + camera.pan[1] * side - (std::floor(y) + 0.5)};
  return pixel;
}

Probe::Probe(const FrameSpec& full, const Grid& grid, const ValueRange& range, double x, double y)
    : grid_(grid), range_(range), next_(full), box_(full.shown.clip.value_or(whole_box(grid))) {
  Shown& shown = next_->shown;
  shown.camera = camera_of_pixel(shown.camera, shown.width, shown.height, x, y);
  shown.width = shown.height = 1;
  shown.shading = Shading::none;
  if (looks_for_extremum()) {
    shown.mode = shown.mode == Mode::minip ? Mode::minip : Mode::mip;
    ask_for_values(range.low, range.high);
  }
  check_frame(*next_, grid);
  const Traversal traversal = make_geometry(*next_, grid).traversal;
  axis_ = static_cast<int>(traversal.axis);
  ascending_ = traversal.ascending;
  high_ = box_.end[axis_] - box_.first[axis_];
}

/// Where rays take no light, the value is found that decides on the pixel, of means and integrals the
/// largest.
bool Probe::looks_for_extremum() const {
  return next_->shown.mode != Mode::composite && next_->shown.mode != Mode::surface;
}

float Probe::reached(const float* rgba) const {
  if (!looks_for_extremum()) return rgba[3];
  return next_->shown.mode == Mode::minip ? 1 - rgba[0] : rgba[0];
}

void Probe::know_range(const ValueRange& range) {
  range_ = range;
  if (looks_for_extremum()) ask_for_values(range.low, range.high);
}

VoxelBox Probe::front_slices(int count) const {
  VoxelBox box = box_;
  if (ascending_)
    box.end[axis_] = box.first[axis_] + count;
  else
    box.first[axis_] = box.end[axis_] - count;
  return box;
}

void Probe::take(const Image& picture) {
  const float* const rgba = picture.pixel(0, 0);
  switch (stage_) {
    case Stage::whole:
      high_opacity_ = reached(rgba);
      wanted_ = (looks_for_extremum() ? 0.999F : 0.5F) * high_opacity_;
      if (rgba[3] < least_opacity) return next_.reset();
      if (looks_for_extremum()) answer_.value = value_of(rgba[0]);
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
    case Stage::value_again:
      return read(rgba[0] / std::max(rgba[3], least_opacity));
  }
  if (high_ - low_ > 1)
    next_->shown.clip = front_slices(middle());
  else
    choose_place();
}

void Probe::choose_place() {
  const double into =
      double(high_ - 1) +
      std::clamp((wanted_ - low_opacity_) / std::max(high_opacity_ - low_opacity_, 1e-6F), 0.0F, 1.0F);
  const double at = ascending_ ? box_.first[axis_] - 0.5 + into : box_.end[axis_] - 0.5 - into;
  const ViewTransform view = make_view(next_->shown.camera, lattice_frame(grid_), 1, 1);
  answer_.hit = true;
  answer_.voxel = glm::clamp(meet(view, axis_, at), glm::dvec3(0.0), glm::dvec3(grid_.dims - 1));
  answer_.world = grid_.origin + grid_.direction * (grid_.spacing * answer_.voxel);
  // An extremum is known since the first picture.
  if (looks_for_extremum()) return next_.reset();
  const int slice = ascending_ ? box_.first[axis_] + high_ - 1 : box_.end[axis_] - high_;
  next_->shown.clip = box_;
  next_->shown.clip->first[axis_] = slice;
  next_->shown.clip->end[axis_] = slice + 1;
  stage_ = Stage::value;
  next_->shown.mode = Mode::composite;
  ask_for_values(range_.low, range_.high);
}

void Probe::ask_for_values(double low, double high) {
  if (!(low < high)) {
    low = std::isfinite(low) ? low : 0;
    high = low + 1;
  }
  value_low_ = low;
  value_high_ = high;
  next_->shown.transfer_function = value_as_red(low, high);
}

double Probe::value_of(double red) const {
  return std::clamp(value_low_ + red * (value_high_ - value_low_), range_.low, range_.high);
}

void Probe::read(double red) {
  answer_.value = value_of(red);
  // Tables resolve some 256 values of the range, so the neighbourhood is looked at once more.
  const double reach = (value_high_ - value_low_) / 32;
  if (stage_ == Stage::value_again || !(reach > 0)) return next_.reset();
  stage_ = Stage::value_again;
  ask_for_values(answer_.value - reach, answer_.value + reach);
}

}  // namespace ringsplat::serve

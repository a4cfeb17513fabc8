#include "sheet_engine/projection.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "classify/adjust.hpp"

namespace ringsplat {
namespace {

/// Whether pixels hold how far a value is beyond one that looks as nothing does.
bool takes_extremum(Mode mode) {
  return mode == Mode::mip || mode == Mode::minip || mode == Mode::attenuated;
}

/// Of what lies before others: by how many powers of two the last colour's value dims them in a unit length.
/// The densest of the function's points says so.
double dimming(const TransferFunction& tf) {
  double densest = 0;
  for (const auto& point : tf.opacities) densest = std::max(densest, point.opacity);
  // Something must be left of a value that is opaque.
  constexpr double most = 0.999;
  return -std::log2(1 - std::min(densest, most));
}

/// The values up to which, or for the least down to which, all extrema look alike.
double seen_from(const SheetFrame& frame) {
  const auto& unseen = frame.transparent.intervals().front();
  return frame.shown.mode == Mode::minip ? unseen.low : unseen.high;
}

/// A pixel's ray in slices that count from the middle one: at k it is at from + k slope along u or v.
struct PixelRay {
  double from[2], slope[2];

  PixelRay(const SheetRays& rays, int slices, int x, int y) {
    for (int i = 0; i < 2; ++i)
      if (const auto& eye = rays.eye) {
        slope[i] = eye->slope(i, x, y);
        from[i] = eye->central_middle[i] + eye->to_middle * (slope[i] - eye->central_slope[i]);
      } else {
        constexpr double unit = 1.0 / double(std::int64_t{1} << 40);
        const RayGrid& grid = rays.grid;
        slope[i] = -rays.shear[i];
        from[i] = unit * double(grid.origin[i] + x * grid.step_x[i] + y * grid.step_y[i]) +
                  slope[i] * 0.5 * (slices - 1);
      }
  }

  /// In the lattice, of a frame's slices.
  glm::dvec3 at(double slice, const FrameGeometry& g) const {
    const auto [u, v] = in_plane(g.traversal.axis);
    glm::dvec3 place(0.5 * (g.slices - 1) + slice);
    place[u] = from[0] + slice * slope[0];
    place[v] = from[1] + slice * slope[1];
    return place;
  }

  /// How many slices it crosses in the box, which ends half a voxel beyond the outer ones, and before clip
  /// planes.
  double slices_in_box(const SheetRays& rays, const FrameGeometry& g) const {
    double enter = -0.5 * g.slices, leave = 0.5 * g.slices;
    for (int i = 0; i < 2; ++i) {
      const double low = -0.5 - from[i], high = rays.voxels[i] - 0.5 - from[i];
      if (slope[i] == 0) {
        if (low > 0 || high < 0) return 0;
        continue;
      }
      const auto [a, b] = std::minmax({low / slope[i], high / slope[i]});
      enter = std::max(enter, a);
      leave = std::min(leave, b);
    }
    for (const LatticePlane& plane : g.clip_planes) {
      const double middle = plane.before(at(0, g)), rise = plane.before(at(1, g)) - middle;
      if (rise > 0) enter = std::max(enter, -middle / rise);
      if (rise < 0) leave = std::min(leave, -middle / rise);
      if (rise == 0 && middle < 0) return 0;
    }
    return std::max(leave - enter, 0.0);
  }

  /// From slice to slice, in the frame's steps.
  double step(const SheetRays& rays) const {
    if (!rays.eye) return 1;
    const auto& axes = rays.eye->axes;
    double squares = 0;
    for (const auto& axis : axes) {
      const double way = axis[0] * slope[0] + axis[1] * slope[1] + axis[2];
      squares += way * way;
    }
    return std::sqrt(squares) / rays.eye->table_length;
  }
};

}  // namespace

Projection make_projection(const SheetFrame& frame, const PlaneCode& code) {
  const TransferFunction& tf = frame.shown.transfer_function;
  Projection p;
  p.mode = frame.shown.mode;
  p.values = frame.shown.values;
  p.opacity = float(std::min(frame.shown.depth.value_or(0.5), 1 - 1.0001 * frame.shown.opaque_threshold));
  p.unit = float(frame.step_length() * frame.unit_length() / code.scale);
  if (takes_extremum(p.mode)) {
    const auto [first, last] = ends_of(tf);
    const double from = seen_from(frame), to = p.mode == Mode::mip     ? last
                                               : p.mode == Mode::minip ? first
                                                                       : tf.colours.back().value;
    p.sign = p.mode == Mode::minip ? -1 : 1;
    p.least = float(code.of(from));
    p.most = float(std::max((to - from) * p.sign * code.scale, 0.0));
    if (p.mode == Mode::attenuated)
      p.unit = p.most > 0 ? float(dimming(tf) * frame.step_length()) / p.most : 0;
  }
  p.isovalue = float(code.of(frame.shown.isovalue));
  const glm::dvec3 colour = tf.evaluate(frame.shown.isovalue).colour;
  for (int c = 0; c < 3; ++c) p.colour[c] = float(colour[c]);
  p.zero = float((0 - code.offset) * code.scale);
  return p;
}

void ProjectionColours::set_function(TransferFunction transfer_function, Mode mode) {
  if (mode == Mode::attenuated) {
    const auto& colours = transfer_function.colours;
    transfer_function.opacities = {{colours.front().value, 1.0}, {colours.back().value, 1.0}};
  }
  if (!colours_.empty() && transfer_function == function_) return;
  function_ = std::move(transfer_function);
  const auto [low, high] = ends_of(function_);
  low_ = low;
  steps_a_unit_ = high > low ? last / (high - low) : 0;
  colours_.clear();
  for (int k = 0; k <= last; ++k) {
    const auto [colour, opacity] = function_.evaluate(std::lerp(low, high, double(k) / last));
    colours_.emplace_back(colour * opacity, opacity);
  }
}

const glm::vec4& ProjectionColours::at(double value) const {
  const double place = std::clamp((value - low_) * steps_a_unit_, 0.0, double(last));
  return colours_[std::size_t(place + 0.5)];
}

void ProjectionColours::colour(const SheetFrame& frame, const SheetRays& rays, const Projection& projection,
                               const PlaneCode& code, const SliceLabels& labels, RegionImage& image) const {
  const bool depth = projection.mode == Mode::surface || projection.mode == Mode::composite;
  if (depth && !projection.values) return;
  const bool extremum = takes_extremum(projection.mode);
  const double from = extremum ? seen_from(frame) : 0,
               of_number = extremum ? projection.sign / code.scale : 1;
  if (!image.touched() && (depth || at(from).a == 0)) return;
  const FrameGeometry& g = frame.geometry;
  const double slice_length = frame.step_length() * frame.unit_length();
  float* row = image.pixels();
  for (int y = image.rect().y0; y < image.rect().y1; ++y, row += image.row_floats())
    for (int x = image.rect().x0; x < image.rect().x1; ++x) {
      float* const pixel = row + 4 * (x - image.rect().x0);
      const PixelRay ray(rays, g.slices, x, y);
      const double crossed = ray.slices_in_box(rays, g);
      double value = from + of_number * pixel[0];
      if (projection.mode == Mode::mean) value /= crossed * slice_length * ray.step(rays);
      // Behind the plane through the volume's middle, in world lengths.
      if (depth) value = g.view.project(ray.at(pixel[0], g)).z / g.view.pixels_per_unit;
      const bool there = depth ? pixel[3] == 1 : crossed > 0;
      glm::vec4 colour = !there              ? glm::vec4(0)
                         : projection.values ? glm::vec4(glm::vec3(float(value)), 1)
                                             : at(value);
      if (labels.plane != nullptr && !projection.values) {
        const auto voxel = [&](int i) {
          return std::clamp(std::int64_t(std::floor(ray.from[i] + 0.5)), std::int64_t{0},
                            std::int64_t(rays.voxels[i] - 1));
        };
        const float* tint = labels.tints + 4 * labels.plane[voxel(1) * labels.pitch + voxel(0)];
        colour = glm::mix(colour, colour.a * glm::vec4(tint[0], tint[1], tint[2], 1), tint[3]);
      }
      for (int c = 0; c < 4; ++c) pixel[c] = colour[c];
    }
}

}  // namespace ringsplat

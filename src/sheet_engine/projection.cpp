#include "sheet_engine/projection.hpp"

#include "classify/adjust.hpp"

namespace ringsplat {
namespace {

/// Whether pixels hold how far a value is beyond one that looks as nothing does.
bool takes_extremum(Mode mode) {
  return mode == Mode::mip || mode == Mode::minip || mode == Mode::attenuated;
}

/// Whether pixels hold the slice in which something is, from the middle one.
bool shows_place(Mode mode) { return mode == Mode::surface || mode == Mode::composite; }

/// Of what lies before others: by how many powers of two the last colour's value dims them in a unit length.
/// The densest of the function's points says so.
double dimming(const TransferFunction& tf) {
  double densest = 0;
  for (const auto& point : tf.opacities) densest = std::max(densest, point.opacity);
  // Something must be left of a value that is opaque.
  constexpr double most = 0.999;
  return -std::log2(1 - std::min(densest, most));
}

/// The values up to which, or for the least down to which, all extrema look alike. Where holes are told from
/// these it lies beyond all values, by as much as floats that are whole numbers stay exact with.
double seen_from(const SheetFrame& frame, const ValueScale& scale) {
  const bool least = frame.shown.mode == Mode::minip;
  if (frame.tells_holes()) {
    const double beyond = std::exp2(std::ilogb(scale.high - scale.low) - 8.0);
    return least ? scale.high + beyond : scale.low - beyond;
  }
  const auto& unseen = frame.transparent.intervals().front();
  return least ? unseen.low : unseen.high;
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

Projection make_projection(const SheetFrame& frame, const ValueScale& scale) {
  const PlaneCode& code = scale.code;
  const TransferFunction& tf = frame.shown.transfer_function;
  Projection p;
  p.mode = frame.shown.mode;
  p.values = frame.shown.values;
  p.opacity = float(std::min(frame.shown.depth.value_or(0.5), 1 - 1.0001 * frame.shown.opaque_threshold));
  p.unit = float(frame.step_length() * frame.unit_length() / code.scale);
  if (takes_extremum(p.mode)) {
    const auto [first, last] = ends_of(tf);
    const double from = seen_from(frame, scale), to = p.mode == Mode::mip     ? last
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

namespace {

/// The colour of one volume's value in a pixel.
struct PixelColour {
  explicit PixelColour(const ProjectedVolume& volume)
      : v(volume),
        extremum(takes_extremum(v.projection.mode)),
        from(extremum ? seen_from(v.frame, v.scale) : 0),
        of_number(extremum ? v.projection.sign / v.scale.code.scale : 1),
        slice_length(v.frame.step_length() * v.frame.unit_length()) {}

  /// Whether rays that have taken nothing show nothing.
  bool starts_clear() const { return is_place() || v.frame.tells_holes() || v.colours.at(from).a == 0; }

  glm::vec4 of(float taken, bool found, const PixelRay& ray, double crossed, const SheetRays& rays) const {
    const FrameGeometry& g = v.frame.geometry;
    double value = from + of_number * taken;
    if (v.frame.tells_holes()) value = of_number < 0 ? std::min(value, ends.high) : std::max(value, ends.low);
    if (v.projection.mode == Mode::mean) value /= crossed * slice_length * ray.step(rays);
    // Behind the plane through the volume's middle, in world lengths.
    if (is_place()) value = g.view.project(ray.at(taken, g)).z / g.view.pixels_per_unit;
    if (is_place() ? !found : !(crossed > 0) || (v.frame.tells_holes() && taken == 0)) return glm::vec4(0);
    if (v.projection.values) return {glm::vec3(float(value)), 1};
    const glm::vec4 colour = v.colours.at(value);
    return v.labels.plane == nullptr ? colour : tinted(colour, ray, rays);
  }

 private:
  bool is_place() const { return shows_place(v.projection.mode); }
  glm::vec4 tinted(const glm::vec4& colour, const PixelRay& ray, const SheetRays& rays) const {
    const auto voxel = [&](int i) {
      return std::clamp(std::int64_t(std::floor(ray.from[i] + 0.5)), std::int64_t{0},
                        std::int64_t(rays.voxels[i] - 1));
    };
    const float* tint = v.labels.tints + 4 * v.labels.plane[voxel(1) * v.labels.pitch + voxel(0)];
    return glm::mix(colour, colour.a * glm::vec4(tint[0], tint[1], tint[2], 1), tint[3]);
  }

  const ProjectedVolume& v;
  const bool extremum;
  const double from, of_number, slice_length;
  const DataRange ends = ends_of(v.frame.shown.transfer_function);
};

}  // namespace

void colour_region(std::span<const ProjectedVolume> volumes, const SheetRays& rays, RegionImage& image,
                   RegionImage* more) {
  const auto& first = volumes.front();
  if (shows_place(first.projection.mode) && !first.projection.values) return;
  const std::vector<PixelColour> colours(volumes.begin(), volumes.end());
  if (!image.touched() && std::ranges::all_of(colours, &PixelColour::starts_clear)) return;
  const FrameGeometry& g = first.frame.geometry;
  const PixelRect& rect = image.rect();
  float *row = image.pixels(), *more_row = more != nullptr ? more->pixels() : nullptr;
  for (int y = rect.y0; y < rect.y1;
       ++y, row += image.row_floats(), more_row += more ? image.row_floats() : 0)
    for (int x = rect.x0; x < rect.x1; ++x) {
      float* const pixel = row + 4 * (x - rect.x0);
      const PixelRay ray(rays, g.slices, x, y);
      const double crossed = ray.slices_in_box(rays, g);
      glm::vec4 sum(0);
      for (std::size_t c = 0; c < colours.size(); ++c) {
        const float taken = c < 3 ? pixel[c] : more_row[4 * (x - rect.x0) + std::ptrdiff_t(c) - 3];
        sum += colours[c].of(taken, pixel[3] == 1, ray, crossed, rays);
      }
      if (colours.size() > 1) sum = glm::min(sum, glm::vec4(1));
      for (int c = 0; c < 4; ++c) pixel[c] = sum[c];
    }
}

}  // namespace ringsplat

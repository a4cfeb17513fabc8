#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"
#include "truth/parallel.hpp"

/// The references that pictures are measured against. They compute the renderer's model but share none of its
/// code: double precision throughout, each pixel by itself, no tables, no incremental positions, no regions,
/// no packed colours.
namespace ringsplat::truth {

/// All that decides a picture, in plain numbers. Grid and frame are checked.
struct Scene {
  Grid grid;
  std::vector<double> values;  ///< grid.voxels() of them, x fastest; all scalar types fit exactly
  /// What is shown of it and by which method. Reduction, opaque threshold and division have no effect.
  FrameSpec frame = {};
  /// Of a voxel, of any length, in place of its central differences; may be empty (splats' truth only).
  std::function<glm::dvec3(const glm::ivec3& voxel)> normal = {};
  /// Of a volume that was cropped: the one that the camera fits, and the place of voxel (0, 0, 0) in it.
  struct CutFrom {
    LatticeFrame whole;
    glm::ivec3 first;
  };
  std::optional<CutFrom> cut_from = std::nullopt;
  std::vector<std::uint8_t> labels = {};  ///< a segmentation's, as many as `values`; none: there is none
  bool shaded() const { return frame.shown.shading == Shading::phong && !frame.shown.values; }
  bool needs_gradients() const { return shaded() || frame.shown.edges; }
  bool of_sheets() const { return std::holds_alternative<Sheets>(frame.how); }
  bool nearest() const { return frame.shown.interpolation == Interpolation::nearest; }
  bool is_slice() const { return std::min({grid.dims.x, grid.dims.y, grid.dims.z}) == 1; }
  /// A voxel's place in `values`.
  std::size_t index(const glm::ivec3& p) const {
    return std::size_t(p.x) +
           std::size_t(grid.dims.x) * (std::size_t(p.y) + std::size_t(grid.dims.y) * std::size_t(p.z));
  }
  Poll poll = {};  ///< called by the thread that waits for a truth of pixels
};

/// The scene of the part in its clip box alone: a volume of its own, seen by the same camera. Throws
/// InputError when the box is none of the volume's.
Scene cropped(const Scene& scene);

/// The whole volume as doubles: 8 bytes a voxel.
std::vector<double> read_values(VolumeSource& source);
std::vector<std::uint8_t> read_labels(VolumeSource& labels);

struct Pixel {
  int x, y;
  bool operator==(const Pixel&) const = default;
};

/// Premultiplied linear red, green, blue, and opacity.
using Rgba = glm::dvec4;

/// Row by row from the top.
std::vector<Pixel> all_pixels(int width, int height);

/// The part of a picture outside of which a truth is exactly transparent: pixels [first, end) of each row,
/// from the top; none where first ≥ end.
struct ScreenBounds {
  struct Row {
    int first = 0, end = 0;
    bool contains(int x) const { return first <= x && x < end; }
  };
  std::vector<Row> rows;
};

/// Rounds to float; `colours` are those of all_pixels(width, height).
Image to_image(int width, int height, std::span<const Rgba> colours);

/// A transfer function evaluated straight from its points.
class TransferCurve {
 public:
  explicit TransferCurve(const TransferFunction& tf);

  struct Sample {
    glm::dvec3 colour{0.0};  ///< straight, linear
    double opacity = 0;      ///< per unit length
  };
  /// Not-a-number is transparent; of points with equal values the last holds at the value itself.
  Sample at(double value) const;
  /// True when some value in [low, high] has opacity above zero; may be true for a jump at an end.
  bool visible(double low, double high) const;
  /// Values at which a line of colour or opacity bends or jumps, ascending, each once.
  const std::vector<double>& knots() const { return knots_; }
  /// Infinities become finite values beyond the function's ends, which can be interpolated.
  double bounded(double value) const;

 private:
  std::vector<double> colour_values_, opacity_values_, opacities_, knots_;
  std::vector<glm::dvec3> colours_;
};

/// A scene's labels' colours, as Shown::tints has them.
class Tints {
 public:
  explicit Tints(const Scene& scene);
  bool any() const { return any_; }
  /// A voxel's tint, and its share.
  const glm::dvec4& of(const glm::ivec3& voxel) const {
    return of_label_[any_ ? scene_.labels[scene_.index(voxel)] : 0];
  }
  /// A colour in the voxel nearest to a lattice point.
  glm::dvec3 on(const glm::dvec3& colour, const glm::dvec3& point) const;

 private:
  const Scene& scene_;
  bool any_;
  std::array<glm::dvec4, 256> of_label_{};  ///< and its share
};

/// Phong's reflection (Phong 1975) as the renderer defines it: white light, two-sided, colours clamped to 1;
/// a zero normal leaves the colour as it is.
class Phong {
 public:
  Phong(const Scene& scene, const ViewTransform& view);
  /// What light makes of a colour: colour · scale + highlight, at most 1.
  struct Light {
    double scale = 1, highlight = 0;
    glm::dvec3 on(const glm::dvec3& colour) const { return glm::min(colour * scale + highlight, 1.0); }
  };
  /// `normal`: of any length. `to_viewer`: a world direction of unit length.
  Light light(const glm::dvec3& normal, const glm::dvec3& to_viewer) const;
  glm::dvec3 shade(const glm::dvec3& colour, const glm::dvec3& normal, const glm::dvec3& to_viewer) const {
    return light(normal, to_viewer).on(colour);
  }
  const glm::dvec3& to_light() const { return to_light_; }

 private:
  PhongMaterial material_;
  glm::dvec3 to_light_;
};

/// From differences along the axes of a lattice, or of any box, to a world direction against the gradient, up
/// to one common factor. `size`: of a step along each axis.
glm::dmat3 against_gradient(const glm::dmat3& direction, const glm::dvec3& size);

/// Central differences of the voxels, against the gradient, in world directions, up to one common factor.
class Gradients {
 public:
  explicit Gradients(const Scene& scene);
  /// One-sided at the border and beside a value that is not finite; zero where the voxel itself is not
  /// finite.
  glm::dvec3 at(const glm::ivec3& voxel) const;
  /// The length of a normal where values change by one a world length.
  double unit() const;
  /// What is left of an extinction where the field has this normal, by Shown::edges.
  double left_at_edge(double extinction, const glm::dvec3& normal) const;

 private:
  const Scene& scene_;
  glm::dmat3 to_world_;    ///< from differences along the lattice axes
  long double scale_ = 1;  ///< brings the values near 1: their differences may be beyond double's range
};

}  // namespace ringsplat::truth

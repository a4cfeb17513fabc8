#pragma once
#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"

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
  bool shaded() const { return frame.shown.shading == Shading::phong; }
  bool of_sheets() const { return std::holds_alternative<Sheets>(frame.how); }
  bool nearest() const { return frame.shown.interpolation == Interpolation::nearest; }
  /// A voxel's place in `values`.
  std::size_t index(const glm::ivec3& p) const {
    return std::size_t(p.x) +
           std::size_t(grid.dims.x) * (std::size_t(p.y) + std::size_t(grid.dims.y) * std::size_t(p.z));
  }
  /// Called now and then by the thread that waits for a truth of pixels; may throw to end its evaluation.
  std::function<void()> poll = {};
};

/// The scene of the part in its clip box alone: a volume of its own, seen by the same camera. Throws
/// InputError when the box is none of the volume's.
Scene cropped(const Scene& scene);

/// The whole volume as doubles: 8 bytes a voxel.
std::vector<double> read_values(VolumeSource& source);

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

}  // namespace ringsplat::truth

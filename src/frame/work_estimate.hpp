#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "frame/frame_geometry.hpp"
#include "volume/slice_dealing.hpp"
#include "volume/volume_sketch.hpp"

namespace ringsplat {

/// What work costs, in seconds of one core; only the ratios decide who gets what.
struct WorkCosts {
  double voxel = 0;    ///< a Renderer, for a visible voxel that it gets
  double pixel = 0;    ///< a Renderer, for a pixel of a visible voxel of a slice
  double payload = 0;  ///< a Renderer, for a payload
  double visible = 0;  ///< a GP, for a visible voxel
  double hollow = 0;   ///< a GP, for any other voxel
  double block = 0;    ///< side of the blocks that voxels travel in, in voxels; 0: they travel alone
  double picture = 0;  ///< rank 0, for a pixel of the finished picture, which it puts together
};
/// On one core of docs/performance.md.
inline constexpr WorkCosts usual_splat_costs{54e-9, 1e-9, 3e-6, 12e-9, 0.2e-9, 0, 3e-9},
    usual_sheet_costs{2e-9, 5e-9, 8e-6, 1e-9, 0.1e-9, 8, 3e-9};
/// What rank 0 spends on a pixel of a picture that it encodes, too.
inline constexpr double encoding_a_pixel = 17e-9;

/// Pixels that use a block of so many voxels a side; in perspective about the volume's middle.
glm::dvec2 size_of_block(const FrameGeometry& geometry, double side);

/// The points of a sketch that a transfer function shows; found again when the function changes, and kept for
/// each axis.
class ShownPoints {
 public:
  /// Blocks of the slices of an axis.
  struct Blocks {
    Axis across = Axis::z;
    double side = 0;  ///< in voxels
    bool operator==(const Blocks&) const = default;
  };
  /// By VolumeSketch::index(), ascending. Where voxels travel in blocks, all points of a block that may show
  /// something. Valid until the function or the blocks' side changes.
  std::span<const std::uint32_t> of(const VolumeSketch& sketch, const TransferFunction& transfer_function,
                                    std::optional<Blocks> blocks = std::nullopt);

 private:
  std::optional<TransferFunction> function_;
  double side_ = 0;                                                 ///< of the blocks; 0: none
  std::array<std::optional<std::vector<std::uint32_t>>, 3> shown_;  ///< by axis across blocks; else the first
};

/// The blocks that voxels travel in; none where they travel alone.
inline std::optional<ShownPoints::Blocks> shown_blocks(const FrameGeometry& g, const WorkCosts& costs) {
  if (costs.block == 0) return std::nullopt;
  return ShownPoints::Blocks{g.traversal.axis, costs.block};
}

/// What one part of the image plane takes to draw.
struct PartWork {
  double seconds = 0;        ///< payloads left out
  double painted = 0;        ///< of these, for pixels
  double inside = 0;         ///< what the pixels show, without what lies beside them
  std::uint64_t layers = 0;  ///< a bit for each layer of the sketch that shows something there
};

/// Where in the image plane a frame's work lies, foreseen from a sketch of the volume. Any rank finds the
/// same: sums are made in one order, of exactly rounded operations.
class WorkEstimate {
 public:
  /// `factor`: of the frame's reduction. Of all layers of the sketch along the traversal's axis, or of one.
  /// Where points were left out, each stands for `stands_for` of the shown.
  WorkEstimate(const FrameGeometry& geometry, const VolumeSketch& sketch,
               std::span<const std::uint32_t> shown, const WorkCosts& costs, int factor, int layer = -1,
               int stands_for = 1);

  /// False when so few points are shown that they say little.
  bool telling() const { return points_ >= 200; }
  /// Of a rectangle of pixels. What a Renderer gets counts also where it lies beside the rectangle and
  /// reaches into it: voxels by the frame's reach, blocks by their size.
  PartWork of(const PixelRect& rect) const;

  double visible_voxels() const { return points_ * voxels_of_point_; }
  int layers() const { return layers_; }
  /// Slices that a layer stands for.
  double slices_of_layer() const { return 1 / layer_of_slice_; }
  /// What each GP spends on its slices.
  std::vector<double> gp_seconds(SliceDealing dealing) const {
    std::vector<double> seconds(std::size_t(dealing.gps), 0.0);
    for (int step = 0; step < slices_; ++step)
      seconds[std::size_t(dealing.owner_of(slice_of(step)))] += slice_seconds(step);
    return seconds;
  }
  /// Seconds until the first slice of these layers is encoded: every GP begins with its own first slice.
  double ready_seconds(std::uint64_t layers) const {
    if (layers == 0) return 0;
    const int first = traversal_.ascending ? std::countr_zero(layers) : int(std::bit_width(layers)) - 1;
    return slice_seconds_[std::size_t(first)];
  }
  /// The volume's slice of a step, and its layer.
  int slice_of(int step) const { return first_slice_ + traversal_.slice_at(step, slices_); }
  int layer_of(int step) const {
    return std::clamp(int((slice_of(step) + 0.5) * layer_of_slice_), 0, layers_ - 1);
  }
  /// Seconds of a GP for the slice of a step.
  double slice_seconds(int step) const { return slice_seconds_[std::size_t(layer_of(step))]; }

 private:
  void make_cells(const FrameGeometry& g, const glm::dvec3& spacing);
  void deposit(const glm::dvec2& place, double work, int layer);
  double within(double x0, double y0, double x1, double y1) const;

  Traversal traversal_;
  int slices_ = 0, first_slice_ = 0, layers_ = 1;
  double layer_of_slice_ = 1;
  int points_ = 0;
  double voxels_of_point_ = 1;
  glm::dvec2 cell_{1.0};  ///< pixels
  glm::dvec2 around_{0.0};
  double painted_ = 0;  ///< part of the work that is the rectangle's own pixels'
  int columns_ = 1, rows_ = 1;
  std::vector<double> work_;           ///< by cell; then sums over all cells above and to the left
  std::vector<std::uint64_t> seen_;    ///< by cell: layers
  std::vector<double> slice_seconds_;  ///< by layer: of a GP, for each slice
};

/// To how many Renderers a block of so many voxels a side goes, on average.
double copies_of_blocks(const FrameGeometry& geometry, double side);
/// What work costs in a frame with such regions: a GP copies a block for all Renderers that see some of it.
WorkCosts costs_in(const FrameGeometry& geometry, WorkCosts costs);

/// A region that is to be dealt, and the seconds that it takes to draw.
struct RegionWork {
  int region = 0;
  double seconds = 0;
};

/// Deals neighbouring regions to each Renderer, whose shares are as `room`: recursive coordinate bisection
/// (Berger and Bokhari 1987). All are cut in two across their longer side, half of the Renderers get either
/// part, and so on. A cut may have a step of a region, so that parts are even where regions are few. Where
/// work moves a little, cuts move a little, so that most regions stay where they were. Returns owners by
/// region, indices of `room`; nobody owns regions that are not among the given ones, which ascend.
std::vector<int> bisect(const Regions& regions, const std::vector<RegionWork>& work,
                        std::span<const double> room);

/// Deals a frame's regions such that Renderers have about the same work. Parts get neighbouring regions
/// (bisect()), all alike where the estimate says little. Other regions go the costliest first,
/// each to the Renderer with the least so far (Graham 1969, longest processing time first), of several sizes
/// where none is asked for: smaller ones are dealt more evenly, larger ones cut less; they are left as they
/// are where the estimate says little. `busy`: by Renderer that gets regions, seconds that its rank is busy
/// otherwise. Every rank finds the same; no bit of the picture depends on it.
void deal_by_work(FrameGeometry& geometry, const WorkEstimate& work, const WorkCosts& costs,
                  const FrameSpec& spec, int renderers, const std::vector<double>& busy);

/// Seconds that Renderers' ranks are busy otherwise, for `busy` above, when `dealt_to` of the Renderers get
/// regions: with their GPs' slices, and the first with the picture, too.
std::vector<double> busy_ranks(const FrameGeometry& geometry, const WorkEstimate& work,
                               const WorkCosts& costs, SliceDealing dealing, int renderers, int dealt_to);

}  // namespace ringsplat

#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <vector>

#include "base/clock.hpp"
#include "frame/frame_geometry.hpp"
#include "record/trace.hpp"
#include "ringsplat/base/bytes.hpp"
#include "splat/encode.hpp"
#include "splat_engine/encoder_frame.hpp"
#include "splat_engine/row_axis.hpp"
#include "splat_engine/row_classifier.hpp"
#include "view/slice_dda.hpp"

namespace ringsplat {

/// Which passes of a (region, slice) have a splat, a bit each (Neumann 1992, Fig. 3): for each row offset, by
/// column offset.
using PassBits = std::array<std::uint16_t, 16>;

struct RegionCounts {
  std::uint32_t splats = 0;
  PassBits passes{};
};

/// A band of consecutive rows of a slice, encoded by one thread at a time: rows are classified, and each
/// region's part is gathered by itself. The parts of all bands, one after another in the order of the rows,
/// are what one band of all rows makes.
class RowBand {
 public:
  /// `frame` must outlive it.
  explicit RowBand(const EncoderFrame& frame);
  virtual ~RowBand() = default;

  /// Rows first … end − 1 of a slice with these visible voxels, which must stay valid until they are done.
  void begin(const SliceView& slice, VisibleVoxels& visible, int first, int end);
  /// Encodes rows, but for voxels whose kernels lie outside the image, until so many visible, or so many
  /// transparent, voxels are done; true once the band is complete. Adds what classifying and shading take to
  /// `stages` unless that is null.
  bool work(int visible_at_most, int voxels_at_most, StageSeconds* stages);

  std::uint64_t visible_voxels() const { return visible_; }
  /// Those that were not looked at, because they lie outside the image.
  std::uint64_t voxels_outside() const { return outside_; }
  /// Regions with splats of the slice, in any order.
  std::span<const int> used_regions() const { return used_; }
  const RegionCounts& counts(int region) const { return counts_[std::size_t(region)]; }
  virtual std::size_t part_bytes(int region) const = 0;
  /// Appends the region's parts of all the slice's `bands`, this one's kind, to a Renderer's payload and
  /// empties them.
  virtual void append_parts(int region, std::span<const std::unique_ptr<RowBand>> bands, Bytes& payload) = 0;
  /// Forgets the slice's counts.
  void clear_counts();

 protected:
  /// Puts the row's visible voxels, of which there are some, into their regions' parts. To begin with
  /// begin_row() if it asks where voxels lie.
  virtual void encode_row(int row) = 0;
  void begin_row();
  /// Of all voxels of rows first … end − 1, whose positions run straight, but for rounding. Leaves the row to
  /// be begun again.
  PixelWindow window_of_rows(int first, int end);
  /// The band's last row, and one more.
  int end() const { return end_; }
  /// To be called by encode_row, once it has left out what it can.
  void make_samples() {
    const OptionalSeconds timed(stages_ ? &stages_->shade : nullptr);
    rows_.make_samples();
  }

  /// Counts splats of a region, of this row's voxels in those columns from `first` on that `mask` has; its
  /// part becomes one of the slice's payloads.
  void count(int region, int first, std::uint64_t mask) {
    RegionCounts& counts = counts_[std::size_t(region)];
    if (counts.splats == 0) used_.push_back(region);
    counts.splats += std::uint32_t(std::popcount(mask));
    std::uint16_t& passes = counts.passes[std::size_t(row_offset_)];
    const unsigned all_columns = (1U << stride_) - 1;
    for (; mask != 0 && passes != all_columns; mask &= mask - 1)
      passes |= std::uint16_t(1U << (first + std::countr_zero(mask)) % stride_);
  }
  bool used(int region) const { return counts_[std::size_t(region)].splats > 0; }
  /// How much of the pixels (inclusive, on the screen) inside the region is opaque, as far as is known here.
  OpaqueCover::Cover hidden(int region, const PixelWindow& window) const {
    if (!cover(region).worth_asking()) return OpaqueCover::Cover::none;
    const PixelRect& pixels = rect(region);
    return cover(region).of(double(window.x0 - pixels.x0), double(window.y0 - pixels.y0),
                            double(window.x1 - pixels.x0), double(window.y1 - pixels.y0));
  }
  const OpaqueCover& cover(int region) const { return frame_.covers[std::size_t(region)]; }
  const PixelRect& rect(int region) const { return frame_.rects[std::size_t(region)]; }
  /// Of a voxel of the row.
  PixelWindow window_of(std::uint32_t column) const {
    const glm::dvec3 position = dda_.position(column);
    return pixel_window(anchor(position.x, position.y), reach_);
  }
  /// Those of the row's columns whose windows can meet pixels [x0, x1) or [y0, y1); a few too many for
  /// rounding.
  Columns reaching_x(double x0, double x1, Columns columns) const {
    return x_.within(x0 - beyond_.x, x1 + beyond_.x, columns);
  }
  Columns reaching_y(double y0, double y1, Columns columns) const {
    return y_.within(y0 - beyond_.y, y1 + beyond_.y, columns);
  }

  const FrameGeometry& geometry_;
  RowClassifier rows_;
  SliceDda dda_;
  KernelReach reach_;

 private:
  int find_row();
  /// Those of the row's columns whose windows can meet the image.
  Columns in_view(Columns all);
  bool is_all_in_view(int first, int end);

  const EncoderFrame& frame_;
  int stride_;
  std::vector<RegionCounts> counts_;  ///< by region
  std::vector<int> used_;             ///< regions with splats in this slice
  RowAxis x_, y_;
  /// A window meets pixels x0 … x1 − 1 when its position is at most reach + ½ beyond them; the rest is for
  /// rounding.
  glm::dvec2 beyond_;
  int row_ = 0, end_ = 0;
  bool row_begun_ = false;
  bool all_in_view_ = false;  ///< of the slice's rows
  int row_offset_ = 0;        ///< within the stride
  std::uint64_t visible_ = 0, outside_ = 0;
  StageSeconds* stages_ = nullptr;
};

std::unique_ptr<RowBand> make_word_band(const EncoderFrame& frame);
std::unique_ptr<RowBand> make_run_band(const EncoderFrame& frame);

}  // namespace ringsplat

#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "classify/classifier.hpp"
#include "classify/empty_space.hpp"
#include "classify/phong.hpp"
#include "frame/frame_geometry.hpp"
#include "raster/opaque_tiles.hpp"
#include "ringsplat/base/bytes.hpp"
#include "splat/splat.hpp"
#include "splat_engine/splat_engine.hpp"
#include "view/slice_dda.hpp"

namespace ringsplat {

/// State that the bands of a frame's slices share; constant while they work.
struct EncoderFrame {
  /// `splat_frame` must outlive it.
  explicit EncoderFrame(const SplatFrame& splat_frame);

  const SplatFrame& frame;
  const FrameGeometry& geometry;
  Classifier classifier;
  std::optional<PhongTable> phong;  ///< of a lit frame
  KernelReach reach;
  int stride;                       ///< between voxels of one pass
  std::vector<PixelRect> rects;     ///< by region
  std::vector<OpaqueTiles> opaque;  ///< by region, as far as Renderers have told
};

/// Half-open range of a row's columns.
struct Columns {
  std::uint32_t first, end;
  bool empty() const { return first >= end; }
};

/// Cuts rows 0 … height − 1 into at most `most` bands with about equal numbers of possibly visible voxels.
/// Band k has rows bounds[k] … bounds[k + 1] − 1, at least one. There are fewer bands, down to one, when a
/// band would not be worth a thread. A slice with nothing to see has no bands: {0}.
std::vector<int> row_bounds(const SliceRuns& runs, int height, int most);

/// Passes of a (region, slice) that have a splat (Neumann 1992, Fig. 3): an element for each row offset, a
/// bit for each column offset.
using PassBits = std::array<std::uint16_t, 16>;

struct RegionCounts {
  std::uint32_t splats = 0;
  PassBits passes{};
};

/// A band of consecutive rows of a slice, encoded by one thread at a time. It finds each row's visible
/// voxels, makes the lit samples of rows that are sent, and collects a part for each region. A region's
/// parts of all bands, in the order of rows, equal the part of a single band of all rows.
class RowBand {
 public:
  /// `frame` must outlive it.
  explicit RowBand(const EncoderFrame& frame);
  virtual ~RowBand() = default;

  /// Begins rows first … end − 1 of a slice. `voxels` holds the slice's visible voxels and must outlive the
  /// work.
  void begin(const SliceView& slice, VisibleVoxels& voxels, int first, int end);
  /// Encodes rows until `visible_at_most` visible voxels or `voxels_at_most` voxels are done; true once the
  /// band is complete. Skips voxels whose kernels lie outside the image.
  bool work(int visible_at_most, int voxels_at_most);

  std::uint64_t visible_voxels() const { return visible_; }
  /// Voxels skipped because they lie outside the image.
  std::uint64_t voxels_outside() const { return outside_; }
  /// Regions with splats of the slice, in any order.
  std::span<const int> used_regions() const { return used_; }
  const RegionCounts& counts(int region) const { return counts_[std::size_t(region)]; }
  /// Appends the region's parts of all `bands` of the slice to a Renderer's payload and empties them. All
  /// bands must be of this one's type.
  virtual void append_parts(int region, std::span<const std::unique_ptr<RowBand>> bands, Bytes& payload) = 0;
  /// Forgets the slice's counts.
  void clear_counts();

 protected:
  /// Puts the row's visible voxels (at least one) into their regions' parts.
  virtual void encode_row(int row) = 0;
  /// Straight colours and corrected opacities of the row's visible voxels. encode_row() asks for them when
  /// any are sent.
  std::span<const ClassifiedSample> make_samples();

  /// Counts splats of a region: this row's voxels in columns first + k for each bit k of `mask`. Marks the
  /// region as used by the slice.
  void count(int region, int first, std::uint64_t mask) {
    RegionCounts& counts = counts_[std::size_t(region)];
    if (counts.splats == 0) used_.push_back(region);
    counts.splats += std::uint32_t(std::popcount(mask));
    std::uint16_t& passes = counts.passes[std::size_t(row_offset_)];
    const unsigned all_columns = (1U << frame_.stride) - 1;
    for (; mask != 0 && passes != all_columns; mask &= mask - 1)
      passes |= std::uint16_t(1U << (first + std::countr_zero(mask)) % frame_.stride);
  }
  bool used(int region) const { return counts_[std::size_t(region)].splats > 0; }
  /// How much of the window (inclusive, image-plane pixels) is opaque inside the region, as far as this GP
  /// knows.
  OpaqueTiles::Cover hidden(int region, const PixelWindow& window) const {
    if (!opaque(region).worth_asking()) return OpaqueTiles::Cover::none;
    const PixelRect& pixels = rect(region);
    return opaque(region).cover(double(window.x0 - pixels.x0), double(window.y0 - pixels.y0),
                                double(window.x1 - pixels.x0), double(window.y1 - pixels.y0));
  }
  const OpaqueTiles& opaque(int region) const { return frame_.opaque[std::size_t(region)]; }
  const PixelRect& rect(int region) const { return frame_.rects[std::size_t(region)]; }
  /// Window of the row's voxel in `column`.
  PixelWindow window_of(std::uint32_t column) const {
    const glm::dvec3 position = dda_.position(column);
    return pixel_window(anchor(position.x, position.y), frame_.reach);
  }
  /// Columns of the row whose windows can meet pixels [low, high) along x (0) or y (1); rounding may add a
  /// few.
  Columns reaching(int along, double low, double high, Columns columns) const {
    low -= beyond_[along];
    high += beyond_[along];
    const double start = dda_.row_start()[along], inverse = inverse_step_[along];
    if (!std::isfinite(inverse)) return start >= low && start <= high ? columns : Columns{0, 0};
    const double a = (low - start) * inverse, b = (high - start) * inverse;
    const double first = std::max(std::min(a, b), double(columns.first)),
                 last = std::min(std::max(a, b), double(columns.end) - 1);
    if (!(first <= last)) return {0, 0};
    const auto truncated = static_cast<std::uint32_t>(static_cast<std::int64_t>(first));
    return {truncated + (double(truncated) < first),
            static_cast<std::uint32_t>(static_cast<std::int64_t>(last)) + 1};
  }

  const EncoderFrame& frame_;
  SliceDda dda_;
  SliceView slice_;
  VisibleRow found_;  ///< the row's visible voxels

 private:
  /// Begins the row, finds its visible voxels whose windows can meet the image, and counts the others.
  void find_row();

  VisibleVoxels* voxels_ = nullptr;   ///< of the slice
  std::vector<RegionCounts> counts_;  ///< by region
  std::vector<int> used_;             ///< regions with splats in this slice
  glm::dvec2 inverse_step_;           ///< from column to column, of pixels
  /// A window meets pixels x0 … x1 − 1 when its position is at most reach + ½ outside them; plus a margin for
  /// rounding.
  glm::dvec2 beyond_;
  int row_ = 0, end_ = 0;  ///< the next row, and one past the band's last
  int row_offset_ = 0;     ///< within the stride
  std::uint64_t visible_ = 0, outside_ = 0;
};

std::unique_ptr<RowBand> make_word_band(const EncoderFrame& frame);
std::unique_ptr<RowBand> make_run_band(const EncoderFrame& frame);

}  // namespace ringsplat

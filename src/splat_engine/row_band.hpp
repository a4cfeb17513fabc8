#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <glm/vec2.hpp>
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
#include "splat/voxel_run.hpp"
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
/// voxels, makes the lit samples of rows that are sent, and collects a part for each region: runs of voxels
/// without positions, which the Renderer computes from the view. A region's parts of all bands, in the order
/// of rows, equal the part of a single band of all rows.
class alignas(64) RowBand {
 public:
  /// `frame` must outlive it.
  explicit RowBand(const EncoderFrame& frame);

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
  /// Appends the region's parts of all `bands` of the slice to a Renderer's payload and empties them.
  static void append_parts(int region, std::span<RowBand> bands, Bytes& payload);
  /// Forgets the slice's counts.
  void clear_counts();

 private:
  /// Not zeroed when it grows, since all of it is written right after.
  template <class T>
  using Buffer = std::vector<T, UninitialisedAllocator<T>>;
  struct Part {
    Buffer<VoxelRun> blocks;
    Buffer<PackedVoxel> voxels;
  };

  /// Voxels of one of the row's blocks that go to a region.
  struct Piece {
    int region;
    std::size_t block;
    std::uint64_t mask;
  };

  /// Begins the row, finds its visible voxels whose windows can meet the image, and counts the others.
  void find_row();
  /// Puts the row's visible voxels (at least one) into their regions' parts.
  void encode_row();
  /// Appends all the row's voxels to the region's part.
  void append_row(int region);
  void find_pieces(const PixelRect& touched, Columns all);
  /// Finds the row's visible voxels whose windows can meet the region. The painter clips any extra voxel.
  void find_pieces_of(int region, Columns columns);
  /// Gives a piece's packed voxels to its region's part.
  void append(const Piece& piece);
  /// Packs the row's visible voxels: straight colours and corrected opacities.
  void pack_samples(PackedVoxel* voxels);

  /// Those voxels of `mask` (bit k: column first + k) that are not hidden.
  std::uint64_t seen_of(int region, std::uint32_t first, std::uint64_t mask) const;
  /// The same for the run of bits begin … end − 1. Halves a run that is partly hidden.
  std::uint64_t seen_of_run(int region, std::uint32_t first, int begin, int end) const;
  /// How much of the window of the voxels in columns first … last is opaque; wider by a rounding error.
  OpaqueTiles::Cover cover_of(int region, std::uint32_t first, std::uint32_t last) const;

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
  Columns reaching(int along, double low, double high, Columns columns) const;

  const EncoderFrame& frame_;
  SliceDda dda_;
  SliceView slice_;
  VisibleRow found_;                  ///< the row's visible voxels
  VisibleVoxels* voxels_ = nullptr;   ///< of the slice
  std::vector<RegionCounts> counts_;  ///< by region
  std::vector<int> used_;             ///< regions with splats in this slice
  std::vector<Part> parts_;           ///< by region
  std::vector<Piece> pieces_;         ///< of the row, region by region
  Buffer<PackedVoxel> packed_;        ///< the row's voxels
  glm::dvec2 inverse_step_;           ///< from column to column, of pixels
  /// A window meets pixels x0 … x1 − 1 when its position is at most reach + ½ outside them; plus a margin for
  /// rounding.
  glm::dvec2 beyond_;
  int row_ = 0, end_ = 0;  ///< the next row, and one past the band's last
  int row_offset_ = 0;     ///< within the stride
  std::uint64_t visible_ = 0, outside_ = 0;
};

}  // namespace ringsplat

#include "splat/region_painter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "raster/composite_row.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "splat/encode.hpp"
#include "splat/painter_kernels.hpp"
#include "splat/voxel_rows.hpp"

namespace ringsplat {

namespace {

constexpr std::ptrdiff_t floats_a_pixel = 4;

hwy::AlignedFreeUniquePtr<float[]> allocate(std::size_t floats) {
  auto memory = hwy::AllocateAligned<float>(floats);
  if (!memory) throw std::bad_alloc();
  return memory;
}

std::ptrdiff_t round_up(std::ptrdiff_t pixels) {
  return (pixels + block_pixels - 1) / block_pixels * block_pixels;
}

/// The region's margins in pixels: windows that reach over its edge write zeros there.
struct Margins {
  std::ptrdiff_t left, right, above, below;
};

/// A window meets the region when its anchor is at most reach + 1 before it or reach behind it, and starts
/// reach before its anchor. On both sides there is also the rest of a block.
Margins stencil_margins(const KernelReach& reach) {
  const std::ptrdiff_t x = 2 * reach.x + 1, y = 2 * reach.y + 1;
  return {x + block_pixels, x + block_pixels, y, y};
}

/// Rows are clipped to the region, but for the rest of the last vector.
constexpr Margins row_margins{0, 16, 0, 0};

}  // namespace

class SliceMemory {
 public:
  /// At least `floats` floats, all 0: painters leave them so.
  float* reserve(std::size_t floats) {
    if (floats > capacity_) {
      floats_ = allocate(floats);
      std::fill_n(floats_.get(), floats, 0.0F);
      capacity_ = floats;
    }
    return floats_.get();
  }

 private:
  std::size_t capacity_ = 0;
  hwy::AlignedFreeUniquePtr<float[]> floats_;
};

std::shared_ptr<SliceMemory> make_slice_memory() { return std::make_shared<SliceMemory>(); }

struct RegionPainter::State {
  int x0, y0, width, height;
  Footprint footprint;
  float opaque_threshold = 0;
  FrameKernel kernel;
  std::optional<Stencil> stencil;  ///< empty for kernels drawn by rows
  bool prepared = false;           ///< buffers and stencil are those of this frame's footprint
  bool touched = false;            ///< the image holds something of this frame
  bool pending = false;            ///< the slice buffer holds something

  std::shared_ptr<SliceMemory> memory;
  SliceBuffer slice;
  hwy::AlignedFreeUniquePtr<float[]> image;
  std::size_t slice_floats = 0;  ///< that the slice buffer takes
  std::ptrdiff_t origin = 0;     ///< of the region's first pixel in it
  std::vector<Run> runs, pixel_runs;
  OpaqueTiles tiles;
  int composites = 0;  ///< since the tiles were brought up to date
  Bytes seen;          ///< the splats not hidden, of the run being drawn
  VoxelRows voxels;
  const AlignedSlice* aligned =
      nullptr;  ///< whose voxels the slice buffer holds; null when it holds sums of splats

  State(int left, int top, int w, int h, std::shared_ptr<SliceMemory> shared)
      : x0(left), y0(top), width(w), height(h), memory(std::move(shared)), tiles(w, h) {}

  std::ptrdiff_t image_row_floats() const { return round_up(width) * floats_a_pixel; }

  void prepare() {
    const auto reach = kernel_reach(footprint);
    const bool small = !kernel.table && kernel.qee_bits == 0 && has_stencil(footprint);
    const auto margins = small ? stencil_margins(reach) : row_margins;
    const std::ptrdiff_t left = round_up(margins.left);
    const std::ptrdiff_t row = left + round_up(width + margins.right);
    if (!image)
      image = allocate(static_cast<std::size_t>(image_row_floats()) * static_cast<std::size_t>(height));
    slice_floats = static_cast<std::size_t>(row * (margins.above + height + margins.below) * floats_a_pixel);
    origin = (margins.above * row + left) * floats_a_pixel;
    slice.row_floats = row * floats_a_pixel;
    slice.width = width;
    slice.height = height;
    runs.assign(static_cast<std::size_t>(small ? height + 2 * reach.y + 1 : height), Run{});
    slice.runs = runs.data();
    stencil.reset();
    if (small) {
      stencil = make_stencil(footprint, slice.row_floats);
      voxels.prepare(slice, int(left), int(reach.x), int(reach.y));
    }
    prepared = true;
  }

  void begin_drawing() {
    if (!prepared) prepare();
    if (!pending) slice.origin = memory->reserve(slice_floats) + origin;
  }

  void note(const DrawCounts& counts) {
    if (counts.drawn == 0) return;
    if (!touched) clear_image();
    touched = pending = true;
  }

  void clear_image() { std::fill_n(image.get(), image_row_floats() * height, 0.0F); }

  DrawCounts draw(const SplatRun& run) const {
    if (kernel.table) return draw_with_texture(slice, *kernel.table, run);
    if (kernel.qee_bits > 0) return draw_fixed_point(slice, footprint, kernel.qee_bits, run);
    return stencil ? draw_with_stencil(slice, *stencil, run) : draw_by_rows(slice, footprint, run);
  }

  /// From runs of anchors to the runs of pixels their windows cover, inside the region.
  const std::vector<Run>& runs_of_pixels() {
    if (!stencil) return runs;
    pixel_runs.assign(static_cast<std::size_t>(height), Run{});
    const int reach_x = stencil->reach_x, reach_y = stencil->reach_y;
    for (int i = 0; i < static_cast<int>(runs.size()); ++i) {
      const Run& anchors = runs[static_cast<std::size_t>(i)];
      if (anchors.empty()) continue;
      const int row = i - reach_y - 1;
      const int first = std::max(anchors.first - reach_x, 0),
                last = std::min(anchors.last + reach_x + 1, width - 1);
      for (int y = std::max(row - reach_y, 0); y <= std::min(row + reach_y + 1, height - 1); ++y) {
        pixel_runs[static_cast<std::size_t>(y)].include(first, last);
      }
    }
    return pixel_runs;
  }

  bool is_opaque(int column, int row) const {
    constexpr int size = OpaqueTiles::tile_size;
    const int x1 = std::min((column + 1) * size, width), y1 = std::min((row + 1) * size, height);
    for (int y = row * size; y < y1; ++y) {
      const float* alpha = image.get() + y * image_row_floats() + 3;
      for (int x = column * size; x < x1; ++x) {
        if (!(1.0F - alpha[x * floats_a_pixel] < opaque_threshold)) return false;
      }
    }
    return true;
  }

  void find_opaque_tiles() {
    for (int row = 0; row < tiles.rows(); ++row) {
      for (int column = 0; column < tiles.columns(); ++column) {
        if (!tiles.is_opaque(column, row) && is_opaque(column, row)) tiles.set_opaque(column, row);
      }
    }
  }

  /// The splats that are not wholly under opaque tiles, in `seen`.
  std::span<const std::byte> without_hidden(std::int64_t left, std::int64_t top,
                                            std::span<const std::byte> splats) {
    const KernelReach reach = kernel_reach(footprint);
    seen.resize(splats.size());
    std::size_t kept = 0;
    for (std::size_t at = 0; at + sizeof(Splat) <= splats.size(); at += sizeof(Splat)) {
      Splat splat;
      std::memcpy(&splat, splats.data() + at, sizeof splat);
      const PixelWindow window = pixel_window({left + splat.anchor_x, top + splat.anchor_y, 0, 0}, reach);
      // Written in any case and kept behind those that are seen: no branch to mispredict.
      std::memcpy(seen.data() + kept, &splat, sizeof splat);
      kept += tiles.hides(window.x0, window.y0, window.x1, window.y1) ? 0 : sizeof splat;
    }
    return std::span<const std::byte>(seen).first(kept);
  }

  /// Calls use(sums, x, y, pixels) for every row's touched pixels, widened to whole blocks. The slice buffer
  /// is 0 after it if `use` leaves its sums so.
  template <class Use>
  void sweep(const Use& use) {
    const auto& touched_runs = runs_of_pixels();
    for (int y = 0; y < height; ++y) {
      const Run& run = touched_runs[static_cast<std::size_t>(y)];
      if (run.empty()) continue;
      const int first = run.first / block_pixels * block_pixels;
      use(slice.origin + y * slice.row_floats + first * floats_a_pixel, first, y,
          int(round_up(run.last + 1)) - first);
    }
    std::fill(runs.begin(), runs.end(), Run{});
  }

  void composite_slice(glm::dvec2 voxel) {
    if (aligned) {
      float factors[4][16];
      if (kernel.lattice_sum) kernel.lattice_sum->fill_factors(x0, y0, voxel, factors);
      voxels.composite(*aligned, image.get(), image_row_floats(), opaque_threshold,
                       kernel.lattice_sum ? factors : nullptr);
      return;
    }
    sweep([&](float* sums, int x, int y, int pixels) {
      if (kernel.lattice_sum)
        kernel.lattice_sum->divide_row(sums, std::size_t(pixels), x0 + x, y0 + y, voxel);
      composite_row(sums, image.get() + y * image_row_floats() + x * floats_a_pixel,
                    std::size_t(pixels * floats_a_pixel), opaque_threshold);
    });
  }

  void forget_slice() {
    if (!pending) return;
    if (aligned)
      voxels.clear();
    else
      sweep([](float* sums, int, int, int pixels) { std::fill_n(sums, pixels * floats_a_pixel, 0.0F); });
    done_with_slice();
  }

  void done_with_slice() {
    aligned = nullptr;
    pending = false;
  }
};

RegionPainter::RegionPainter(int x0, int y0, int width, int height, std::shared_ptr<SliceMemory> memory) {
  if (width < 1 || height < 1) {
    throw InputError(fmt::format("a region of {}x{} pixels has no pixels", width, height),
                     "give a positive image and region size");
  }
  state_ = std::make_unique<State>(x0, y0, width, height, std::move(memory));
}
RegionPainter::~RegionPainter() = default;
RegionPainter::RegionPainter(RegionPainter&&) noexcept = default;
RegionPainter& RegionPainter::operator=(RegionPainter&&) noexcept = default;

void RegionPainter::use(std::shared_ptr<SliceMemory> memory) { state_->memory = std::move(memory); }

void RegionPainter::begin_frame(const FrameKernel& kernel, float opaque_threshold) {
  auto& s = *state_;
  s.forget_slice();
  s.footprint = kernel.footprint;
  s.kernel = kernel;
  s.opaque_threshold = opaque_threshold;
  s.prepared = false;
  s.touched = false;
  s.tiles.clear();
  s.composites = 0;
}

template <class Voxel>
DrawnBlocks RegionPainter::draw_blocks(const AlignedSlice& slice, const VoxelBlocks<Voxel>& blocks,
                                       std::uint64_t most) {
  auto& s = *state_;
  s.begin_drawing();
  const PlacedVoxels placed = s.voxels.place(slice, s.x0, s.y0, blocks, most);
  const DrawCounts counts{placed.drawn, placed.voxels - placed.drawn, 0};
  if (placed.top < placed.bottom) {
    s.aligned = &slice;
    s.pending = true;
  }
  s.note(counts);
  return {placed.blocks, counts};
}
template DrawnBlocks RegionPainter::draw_blocks(const AlignedSlice&, const VoxelBlocks<FloatVoxel>&,
                                                std::uint64_t);
template DrawnBlocks RegionPainter::draw_blocks(const AlignedSlice&, const VoxelBlocks<HalfVoxel>&,
                                                std::uint64_t);
template DrawnBlocks RegionPainter::draw_blocks(const AlignedSlice&, const VoxelBlocks<ByteVoxel>&,
                                                std::uint64_t);

DrawCounts RegionPainter::draw(std::int32_t base_x, std::int32_t base_y, std::span<const std::byte> splats) {
  auto& s = *state_;
  if (splats.size() < sizeof(Splat)) return {};
  s.begin_drawing();
  const std::int64_t left = std::int64_t{base_x} - s.x0, top = std::int64_t{base_y} - s.y0;
  const auto visible = s.tiles.worth_asking() ? s.without_hidden(left, top, splats) : splats;
  const SplatRun run{visible.data(), visible.size() / sizeof(Splat), left, top};
  auto counts = s.draw(run);
  counts.hidden = (splats.size() - visible.size()) / sizeof(Splat);
  s.note(counts);
  return counts;
}

void RegionPainter::composite(glm::dvec2 voxel) {
  auto& s = *state_;
  if (!s.touched) s.forget_slice();
  if (!s.pending) return;
  s.composite_slice(voxel);
  s.done_with_slice();
  // Reading the whole image takes as long as a slice's composition; the news of an opaque tile can wait a
  // little.
  constexpr int now_and_then = 8;
  if (s.opaque_threshold > 0 && ++s.composites % now_and_then == 0) s.find_opaque_tiles();
}

const OpaqueTiles& RegionPainter::opaque_tiles() const { return state_->tiles; }

bool RegionPainter::touched() const { return state_->touched; }

void RegionPainter::read_tile(std::span<float> rgba) const {
  const auto& s = *state_;
  const std::size_t row = static_cast<std::size_t>(s.width) * 4;
  if (rgba.size() != row * static_cast<std::size_t>(s.height)) {
    throw InputError(
        fmt::format("a tile of {}x{} pixels does not fit {} floats", s.width, s.height, rgba.size()),
        "give four floats a pixel");
  }
  if (!s.touched) {
    std::fill(rgba.begin(), rgba.end(), 0.0F);
    return;
  }
  for (int y = 0; y < s.height; ++y) {
    std::copy_n(s.image.get() + y * s.image_row_floats(), row,
                rgba.data() + static_cast<std::size_t>(y) * row);
  }
}

}  // namespace ringsplat

#include "ringsplat/splat/region_painter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <optional>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "ringsplat/splat/encode.hpp"
#include "splat/painter_kernels.hpp"

namespace ringsplat {

namespace {

constexpr std::ptrdiff_t floats_a_pixel = 4;

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

struct RegionPainter::State {
  int x0, y0, width, height;
  Footprint footprint;
  std::optional<Stencil> stencil;  ///< empty for kernels drawn by rows
  bool prepared = false;           ///< buffers and stencil are those of this frame's footprint
  bool touched = false;            ///< the image holds something of this frame
  bool pending = false;            ///< the slice buffer holds something

  SliceBuffer slice;
  std::size_t capacity = 0;
  hwy::AlignedFreeUniquePtr<float[]> slice_floats,
      image;  ///< the slice's floats are 0 wherever no splat of this slice was drawn
  std::vector<Run> runs, pixel_runs;

  State(int left, int top, int w, int h) : x0(left), y0(top), width(w), height(h) {}

  std::ptrdiff_t image_row_floats() const { return round_up(width) * floats_a_pixel; }

  void prepare() {
    const auto reach = kernel_reach(footprint);
    const bool small = has_stencil(footprint);
    const auto margins = small ? stencil_margins(reach) : row_margins;
    const std::ptrdiff_t left = round_up(margins.left);
    const std::ptrdiff_t row = left + round_up(width + margins.right);
    reserve(static_cast<std::size_t>(row * (margins.above + height + margins.below) * floats_a_pixel));
    slice.origin = slice_floats.get() + (margins.above * row + left) * floats_a_pixel;
    slice.row_floats = row * floats_a_pixel;
    slice.width = width;
    slice.height = height;
    runs.assign(static_cast<std::size_t>(small ? height + 2 * reach.y + 1 : height), Run{});
    slice.runs = runs.data();
    stencil.reset();
    if (small) stencil = make_stencil(footprint, slice.row_floats);
    prepared = true;
  }

  void reserve(std::size_t floats) {
    if (!image)
      image = allocate(static_cast<std::size_t>(image_row_floats()) * static_cast<std::size_t>(height));
    if (floats <= capacity) return;
    slice_floats = allocate(floats);
    std::fill_n(slice_floats.get(), floats, 0.0F);
    capacity = floats;
  }

  static hwy::AlignedFreeUniquePtr<float[]> allocate(std::size_t floats) {
    auto memory = hwy::AllocateAligned<float>(floats);
    if (!memory) throw std::bad_alloc();
    return memory;
  }

  void clear_image() {
    const auto pixels =
        static_cast<std::size_t>(image_row_floats() / floats_a_pixel) * static_cast<std::size_t>(height);
    for (std::size_t i = 0; i < pixels; ++i) {
      float* pixel = image.get() + 4 * i;
      pixel[0] = pixel[1] = pixel[2] = 0.0F;
      pixel[3] = 1.0F;
    }
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

  /// Calls use(slice floats, image floats, count) for every row's touched pixels, widened to whole blocks.
  template <class Use>
  void sweep(Use&& use) {
    const auto& touched_runs = runs_of_pixels();
    for (std::ptrdiff_t y = 0; y < height; ++y) {
      const Run& run = touched_runs[static_cast<std::size_t>(y)];
      if (run.empty()) continue;
      const std::ptrdiff_t first = run.first / block_pixels * block_pixels, end = round_up(run.last + 1);
      use(slice.origin + y * slice.row_floats + first * floats_a_pixel,
          image.get() + y * image_row_floats() + first * floats_a_pixel,
          static_cast<std::size_t>((end - first) * floats_a_pixel));
    }
    std::fill(runs.begin(), runs.end(), Run{});
    pending = false;
  }
};

RegionPainter::RegionPainter(int x0, int y0, int width, int height) {
  if (width < 1 || height < 1) {
    throw InputError(fmt::format("a region of {}x{} pixels has no pixels", width, height),
                     "give a positive image and region size");
  }
  state_ = std::make_unique<State>(x0, y0, width, height);
}
RegionPainter::~RegionPainter() = default;
RegionPainter::RegionPainter(RegionPainter&&) noexcept = default;
RegionPainter& RegionPainter::operator=(RegionPainter&&) noexcept = default;

void RegionPainter::begin_frame(const Footprint& footprint) {
  auto& s = *state_;
  if (s.pending) s.sweep([](float* slice, float*, std::size_t floats) { std::fill_n(slice, floats, 0.0F); });
  s.footprint = footprint;
  s.prepared = false;
  s.touched = false;
}

DrawCounts RegionPainter::draw(std::int32_t base_x, std::int32_t base_y, std::span<const std::byte> splats) {
  auto& s = *state_;
  const std::size_t count = splats.size() / sizeof(Splat);
  if (count == 0) return {};
  if (!s.prepared) s.prepare();
  const SplatRun run{splats.data(), count, std::int64_t{base_x} - s.x0, std::int64_t{base_y} - s.y0};
  const auto counts =
      s.stencil ? draw_with_stencil(s.slice, *s.stencil, run) : draw_by_rows(s.slice, s.footprint, run);
  if (counts.drawn > 0) {
    if (!s.touched) s.clear_image();
    s.touched = s.pending = true;
  }
  return counts;
}

void RegionPainter::composite() {
  if (state_->pending) state_->sweep(composite_row);
}

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
    const float* from = s.image.get() + y * s.image_row_floats();
    float* to = rgba.data() + static_cast<std::size_t>(y) * row;
    for (std::size_t i = 0; i < row; i += 4) {
      to[i] = from[i];
      to[i + 1] = from[i + 1];
      to[i + 2] = from[i + 2];
      to[i + 3] = 1.0F - from[i + 3];
    }
  }
}

}  // namespace ringsplat

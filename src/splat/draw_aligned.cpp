#include "splat/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/draw_aligned.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>

#include "splat/aligned_row.hpp"
#include "splat/pixel_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

#if RINGSPLAT_ONE_BY_ONE

void add_taps(const float* taps, int count, int tap_floats, const float* weights, float* pixels) {
  for (int i = 0; i < 4 * block_pixels; ++i) {
    float sum = pixels[i];
    for (int tap = 0; tap < count; ++tap)
      sum = std::fma(weights[tap * 4 * block_pixels + i], taps[tap * tap_floats + i], sum);
    pixels[i] = sum;
  }
}

#else

/// Adds `count` taps to a block of pixels, the leftmost voxel's first.
HWY_INLINE void add_taps(const float* taps, int count, int tap_floats, const float* weights, float* pixels) {
  const Floats d;
  for (std::size_t at = 0; at < 4 * block_pixels; at += lanes) {
    auto sum = hn::LoadU(d, pixels + at);
    for (int tap = 0; tap < count; ++tap) {
      sum = hn::MulAdd(hn::LoadU(d, weights + tap * 4 * block_pixels + at),
                       hn::LoadU(d, taps + tap * tap_floats + at), sum);
    }
    hn::StoreU(sum, d, pixels + at);
  }
}

#endif

HWY_INLINE void spread_colours(const AlignedRow& row, const AlignedSlice& slice, float* colours) {
  for (int k = 0; k < row.count; ++k) {
    const VoxelColour& voxel = row.voxels[k];
    const auto opacity = static_cast<float>(static_cast<double>(voxel.opacity) * slice.opacity_weight);
    const bool plausible = std::abs(opacity) < largest_coefficient;
    const auto colour = premultiply(&voxel.red, plausible ? opacity : 0.0F);
    for (int copy = 0; copy < slice.step_x; ++copy, colours += 4) store_pixel(colour, colours);
  }
}

/// `taps`: those of the slice, known to the compiler where it matters.
HWY_INLINE void convolve(const SliceBuffer& buffer, const AlignedSlice& slice, const AlignedRow& row,
                         const float* colours, int pixels, int taps) {
  const int top = row.y - slice.reach_y, first = std::max(slice.first_row, -top),
            end = std::min(slice.end_row, buffer.height - top);
  const int tap_floats = 4 * slice.step_x, row_weights = taps * 4 * block_pixels;
  float* corner = buffer.origin + top * buffer.row_floats + (row.x - slice.reach_x) * std::ptrdiff_t{4};
  const float* leftmost = colours - (taps - 1) * std::ptrdiff_t{tap_floats};
  for (int floats = 0; floats < 4 * pixels; floats += 4 * block_pixels) {
    const float* weights = slice.weights.data() + first * row_weights;
    float* block = corner + first * buffer.row_floats + floats;
    for (int i = first; i < end; ++i, weights += row_weights, block += buffer.row_floats)
      add_taps(leftmost + floats, taps, tap_floats, weights, block);
  }
}

/// Returns how many pixels from the first window's on were added to.
int DrawAligned(const SliceBuffer& buffer, const AlignedSlice& slice, const AlignedRow& row, float* scratch) {
  const int before = (slice.taps - 1) * slice.step_x, given = row.count * slice.step_x;
  const int covered = given - slice.step_x + 2 * slice.reach_x + 2,
            pixels = (covered + block_pixels - 1) / block_pixels * block_pixels;
  float* colours = scratch + std::ptrdiff_t{4} * before;
  // The taps of the first and of the last block reach beyond the voxels.
  std::fill(scratch, colours, 0.0F);
  spread_colours(row, slice, colours);
  std::fill(colours + std::ptrdiff_t{4} * given, colours + std::ptrdiff_t{4} * std::max(pixels, given), 0.0F);
  if (slice.taps == 4)
    convolve(buffer, slice, row, colours, pixels, 4);
  else
    convolve(buffer, slice, row, colours, pixels, slice.taps);
  return pixels;
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {
namespace {

HWY_EXPORT(DrawAligned);

bool reaches(const SliceBuffer& buffer, const AlignedSlice& slice, int x, int y) {
  return std::any_of(slice.covered.begin(), slice.covered.end(),
                     [&](const AlignedSlice::Offset& at) { return buffer.holds(x + at.x, y + at.y); });
}

/// Voxels with a weight above zero inside the region. Those whose columns all lie inside are alike.
std::uint64_t count_drawn(const SliceBuffer& buffer, const AlignedSlice& slice, const AlignedRow& row) {
  const bool rows_inside = row.y >= slice.reach_y && row.y + slice.reach_y + 1 < buffer.height;
  const auto columns_inside = [&](int x) {
    return x >= slice.reach_x && x + slice.reach_x + 1 < buffer.width;
  };
  const auto x_of = [&](int k) { return row.x + k * slice.step_x; };
  int first = 0, end = row.count;
  std::uint64_t drawn = 0;
  for (; first < end && !columns_inside(x_of(first)); ++first)
    drawn += reaches(buffer, slice, x_of(first), row.y);
  for (; first < end && !columns_inside(x_of(end - 1)); --end)
    drawn += reaches(buffer, slice, x_of(end - 1), row.y);
  if (first < end && (rows_inside || reaches(buffer, slice, x_of(first), row.y)))
    drawn += std::uint64_t(end - first);
  return drawn;
}

/// Windows that reach over the region's edge leave something in its margins.
void clear_margins(const SliceBuffer& buffer, const AlignedSlice& slice, int y, int left, int end) {
  if (left >= 0 && end <= buffer.width) return;
  for (int row = std::max(y - slice.reach_y, 0); row < std::min(y + slice.reach_y + 2, buffer.height);
       ++row) {
    float* pixels = buffer.origin + row * buffer.row_floats;
    if (left < 0) std::fill(pixels + std::ptrdiff_t{4} * left, pixels, 0.0F);
    if (end > buffer.width)
      std::fill(pixels + std::ptrdiff_t{4} * buffer.width, pixels + std::ptrdiff_t{4} * end, 0.0F);
  }
}

}  // namespace

DrawCounts draw_aligned(const SliceBuffer& buffer, const AlignedSlice& slice, const AlignedRow& row,
                        std::vector<float>& scratch) {
  const auto room = std::size_t(4) * std::size_t((row.count + 2 * slice.taps) * slice.step_x + block_pixels);
  if (scratch.size() < room) scratch.resize(room);
  const int pixels = HWY_DYNAMIC_DISPATCH(DrawAligned)(buffer, slice, row, scratch.data());
  const int left = row.x - slice.reach_x;
  clear_margins(buffer, slice, row.y, left, left + pixels);
  buffer.runs[row.y + slice.reach_y + 1].include(row.x, row.x + (row.count - 1) * slice.step_x);
  DrawCounts counts;
  counts.drawn = count_drawn(buffer, slice, row);
  counts.clipped = std::uint64_t(row.count) - counts.drawn;
  return counts;
}

}  // namespace ringsplat
#endif

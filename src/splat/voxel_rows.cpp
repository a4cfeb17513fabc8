#include "splat/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/voxel_rows.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <utility>

#include "splat/pixel_vectors-inl.hpp"
#include "splat/voxel_rows.hpp"
#include "splat/whole_steps.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

#if RINGSPLAT_ONE_BY_ONE

void ConvolveBlocks(const BlockSums& in, float* sums) {
  for (int i = 0; i < in.blocks * block_pixels * 4; ++i) {
    float sum = 0;
    for (int row = 0; row < in.rows; ++row) {
      const float* voxel = in.voxels + row * in.row_floats + i;
      const float* weight = in.weights - row * in.weights_floats + i % (block_pixels * 4);
      for (int tap = 0; tap < in.taps; ++tap)
        sum = std::fma(weight[tap * tap_floats], voxel[tap * in.voxel_floats], sum);
    }
    sums[i] = sum;
  }
}

#else

/// `rows`, `taps`: those of `in`, known to the compiler where it matters.
HWY_INLINE void convolve(const BlockSums& in, int rows, int taps, float* HWY_RESTRICT sums) {
  const Floats d;
  for (int block = 0; block < in.blocks; ++block) {
    for (std::size_t at = 0; at < 4 * block_pixels; at += lanes) {
      const float* voxels = in.voxels + block * 4 * block_pixels + at;
      const float* weights = in.weights + at;
      auto sum = hn::Zero(d);
      for (int row = 0; row < rows; ++row, voxels += in.row_floats, weights -= in.weights_floats) {
        for (int tap = 0; tap < taps; ++tap)
          sum = hn::MulAdd(hn::LoadU(d, weights + tap * tap_floats), hn::LoadU(d, voxels + tap * in.voxel_floats), sum);
      }
      hn::Store(sum, d, sums + block * 4 * block_pixels + at);
    }
  }
}

/// A small kernel at one pixel a voxel, as most are.
HWY_INLINE bool convolve_small(const BlockSums& in, float* sums) {
  if (in.taps != 4) return false;
  switch (in.rows) {
    case 1:
      convolve(in, 1, 4, sums);
      return true;
    case 2:
      convolve(in, 2, 4, sums);
      return true;
    case 3:
      convolve(in, 3, 4, sums);
      return true;
    case 4:
      convolve(in, 4, 4, sums);
      return true;
    default:
      return false;
  }
}

void ConvolveBlocks(const BlockSums& in, float* sums) {
  if (!convolve_small(in, sums)) convolve(in, in.rows, in.taps, sums);
}

#endif

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {
namespace {

HWY_EXPORT(ConvolveBlocks);

bool reaches(const SliceBuffer& buffer, const AlignedSlice& slice, int x, int y) {
  return std::any_of(slice.covered.begin(), slice.covered.end(),
                     [&](const AlignedSlice::Offset& at) { return buffer.holds(x + at.x, y + at.y); });
}

}  // namespace

void convolve_blocks(const BlockSums& in, float* sums) { HWY_DYNAMIC_DISPATCH(ConvolveBlocks)(in, sums); }

void VoxelRows::prepare(const SliceBuffer& buffer, int left, int reach_x, int reach_y) {
  buffer_ = &buffer;
  left_ = left;
  above_ = reach_y + 1;
  const int first = left / block_pixels, inside = (buffer.width + block_pixels - 1) / block_pixels,
            behind = (2 * reach_x + 2 + most_whole_steps) / block_pixels + 1;
  words_ = std::size_t(first + inside + behind + 63) / 64;
  blocks_.assign(std::size_t(buffer.height + 2 * reach_y + 1) * words_, 0);
  inside_.assign(words_, 0);
  for (int block = first; block < first + inside; ++block)
    inside_[std::size_t(block) / 64] |= std::uint64_t{1} << block % 64;
  top_ = std::numeric_limits<int>::max();
  bottom_ = std::numeric_limits<int>::min();
  sums_ = hwy::AllocateAligned<float>(std::size_t(inside) * block_pixels * 4);
  if (!sums_) throw std::bad_alloc();
}

void VoxelRows::mark(int y, int first, int last) {
  std::uint64_t* const row = row_blocks(y);
  const auto begin = std::size_t(first + left_) / block_pixels, end = std::size_t(last + left_) / block_pixels;
  constexpr std::uint64_t all = ~std::uint64_t{0};
  for (std::size_t word = begin / 64; word <= end / 64; ++word) {
    const std::uint64_t from = word == begin / 64 ? all << begin % 64 : all,
                        to = word == end / 64 ? all >> (63 - end % 64) : all;
    row[word] |= from & to;
  }
}

/// Voxels whose columns all lie inside are alike.
std::uint64_t VoxelRows::count_drawn(const AlignedSlice& slice, int x, int y, int count) const {
  const bool rows_inside = y >= slice.reach_y && y + slice.reach_y + 1 < buffer_->height;
  const auto columns_inside = [&](int column) {
    return column >= slice.reach_x && column + slice.reach_x + 1 < buffer_->width;
  };
  int end = x + count * slice.step_x;
  std::uint64_t drawn = 0;
  for (; x < end && !columns_inside(x); x += slice.step_x) drawn += reaches(*buffer_, slice, x, y);
  for (; x < end && !columns_inside(end - slice.step_x); end -= slice.step_x)
    drawn += reaches(*buffer_, slice, end - slice.step_x, y);
  if (x < end && (rows_inside || reaches(*buffer_, slice, x, y))) drawn += std::uint64_t((end - x) / slice.step_x);
  return drawn;
}

VoxelRows::Reaching VoxelRows::reaching(const AlignedSlice& slice, int y) const {
  const int least = y + slice.reach_y - slice.end_row + 1, step = slice.step_y;
  const int steps = std::max(least - top_ + step - 1, 0) / step;
  return {top_ + steps * step, std::min(y + slice.reach_y - slice.first_row + 1, bottom_), step};
}

void VoxelRows::sum(const AlignedSlice& slice, const Reaching& rows, int y, int block, int count) {
  const int x = block * block_pixels - left_;
  const int leftmost = x + slice.reach_x - (slice.taps - 1) * slice.step_x;
  // Steps are powers of two: a remainder of negative numbers too.
  const int phase = (x + slice.reach_x - anchor_x_) & (slice.step_x - 1);
  const std::ptrdiff_t row_weights = std::ptrdiff_t{slice.taps} * tap_floats;
  const int row = y - rows.first + slice.reach_y;
  convolve_blocks({pixel(leftmost, rows.first),
                   rows.step * buffer_->row_floats,
                   slice.weights.data() + row * row_weights + std::ptrdiff_t{4} * phase,
                   rows.step * row_weights, (rows.end - rows.first + rows.step - 1) / rows.step, slice.taps,
                   4 * slice.step_x, count},
                  sums_.get());
}

void VoxelRows::clear() {
  for (int y = top_; y < bottom_; ++y) {
    std::uint64_t* const row = row_blocks(y);
    for (std::size_t word = 0; word < words_; ++word) {
      for (std::uint64_t bits = std::exchange(row[word], 0); bits != 0; bits &= bits - 1) {
        const int block = int(word) * 64 + std::countr_zero(bits);
        std::memset(pixel(block * block_pixels - left_, y), 0, sizeof(float) * 4 * block_pixels);
      }
    }
  }
  top_ = std::numeric_limits<int>::max();
  bottom_ = std::numeric_limits<int>::min();
}

}  // namespace ringsplat
#endif

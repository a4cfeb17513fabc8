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

void convolve(const BlockSums& in, float* HWY_RESTRICT sums) {
  const Floats d;
  for (int block = 0; block < in.blocks; ++block) {
    for (std::size_t at = 0; at < 4 * block_pixels; at += lanes) {
      const float* voxels = in.voxels + block * 4 * block_pixels + at;
      const float* weights = in.weights + at;
      auto sum = hn::Zero(d);
      for (int row = 0; row < in.rows; ++row, voxels += in.row_floats, weights -= in.weights_floats) {
        for (int tap = 0; tap < in.taps; ++tap)
          sum = hn::MulAdd(hn::LoadU(d, weights + tap * tap_floats),
                           hn::LoadU(d, voxels + tap * in.voxel_floats), sum);
      }
      hn::Store(sum, d, sums + block * 4 * block_pixels + at);
    }
  }
}

/// The same for four taps, as most kernels have, of `blocks` blocks from `at` on: sums of their own, so that
/// no addition waits for the one before. `alike`: at one pixel a voxel a tap has one weight in all pixels.
template <int rows, bool alike, int blocks>
HWY_INLINE void convolve_some(const BlockSums& in, std::ptrdiff_t at, float* HWY_RESTRICT sums) {
  const Floats d;
  constexpr int taps = 4, parts = 4 * block_pixels / int(lanes);
  FloatVector sum[blocks * parts];
  for (auto& part : sum) part = hn::Zero(d);
  for (int row = 0; row < rows; ++row) {
    for (int tap = 0; tap < taps; ++tap) {
      const float* weight = in.weights + tap * tap_floats - row * in.weights_floats;
      const float* voxels = in.voxels + at + row * in.row_floats + tap * in.voxel_floats;
      for (int i = 0; i < blocks * parts; ++i)
        sum[i] = hn::MulAdd(alike ? hn::Set(d, *weight) : hn::LoadU(d, weight + i % parts * int(lanes)),
                            hn::LoadU(d, voxels + i * int(lanes)), sum[i]);
    }
  }
  for (int i = 0; i < blocks * parts; ++i) hn::Store(sum[i], d, sums + at + i * int(lanes));
}

template <int rows, bool alike>
HWY_INLINE void convolve_rows(const BlockSums& in, float* HWY_RESTRICT sums) {
  constexpr int block_floats = 4 * block_pixels;
  int block = 0;
  for (; block + 2 <= in.blocks; block += 2) convolve_some<rows, alike, 2>(in, block * block_floats, sums);
  if (block < in.blocks) convolve_some<rows, alike, 1>(in, block * block_floats, sums);
}

template <bool alike>
HWY_INLINE void convolve_four_taps(const BlockSums& in, float* sums) {
  switch (in.rows) {
    case 1:
      return convolve_rows<1, alike>(in, sums);
    case 2:
      return convolve_rows<2, alike>(in, sums);
    case 3:
      return convolve_rows<3, alike>(in, sums);
    case 4:
      return convolve_rows<4, alike>(in, sums);
    default:
      return convolve(in, sums);
  }
}

void ConvolveBlocks(const BlockSums& in, float* sums) {
  if (in.taps != 4)
    convolve(in, sums);
  else if (in.voxel_floats == 4)
    convolve_four_taps<true>(in, sums);
  else
    convolve_four_taps<false>(in, sums);
}

#endif

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(ConvolveBlocks);

void convolve_blocks(const BlockSums& in, float* sums) { HWY_DYNAMIC_DISPATCH(ConvolveBlocks)(in, sums); }

void VoxelRows::prepare(const SliceBuffer& buffer, int left, int reach_x, int reach_y) {
  buffer_ = &buffer;
  left_ = left;
  above_ = reach_y + 1;
  const int inside = (buffer.width + block_pixels - 1) / block_pixels * block_pixels,
            behind = 2 * reach_x + 1 + most_whole_steps;
  words_ = std::size_t(left + inside + behind) / 64 + 1;
  filled_.assign(std::size_t(buffer.height + 2 * reach_y + 1) * words_, 0);
  inside_.assign(words_, 0);
  for (int pixel = left; pixel < left + inside; ++pixel)
    inside_[std::size_t(pixel) / 64] |= std::uint64_t{1} << pixel % 64;
  forget_rows();
  sums_ = hwy::AllocateAligned<float>(std::size_t(inside) * 4);
  if (!sums_) throw std::bad_alloc();
}

void VoxelRows::forget_rows() {
  top_ = std::numeric_limits<int>::max();
  bottom_ = std::numeric_limits<int>::min();
}

VoxelRows::Reaching VoxelRows::reaching(const AlignedSlice& slice, int y) const {
  const int least = y + slice.reach_y - slice.end_row + 1, step = slice.step_y;
  const int steps = std::max(least - top_ + step - 1, 0) / step;
  return {top_ + steps * step, std::min(y + slice.reach_y - slice.first_row + 1, bottom_), step};
}

void VoxelRows::sum(const AlignedSlice& slice, const Reaching& rows, int x, int y, int blocks) {
  const int leftmost = x + slice.reach_x - (slice.taps - 1) * slice.step_x;
  // Steps are powers of two: a remainder of negative numbers too.
  const int phase = (x + slice.reach_x - phase_x_) & (slice.step_x - 1);
  const std::ptrdiff_t row_weights = std::ptrdiff_t{slice.taps} * tap_floats;
  const int row = y - rows.first + slice.reach_y;
  convolve_blocks(
      {pixel(leftmost, rows.first), rows.step * buffer_->row_floats,
       slice.weights.data() + row * row_weights + std::ptrdiff_t{4} * phase, rows.step * row_weights,
       (rows.end - rows.first + rows.step - 1) / rows.step, slice.taps, 4 * slice.step_x, blocks},
      sums_.get());
}

void VoxelRows::clear() {
  for (int y = top_; y < bottom_; ++y) {
    for (std::size_t word = 0; word < words_; ++word) {
      const std::uint64_t filled = std::exchange(filled_[at(y) + word], 0);
      for_each_bit_run(whole_blocks(filled), [&](int first, int count) {
        float* pixels = pixel(int(word) * 64 + first - left_, y);
        constexpr int block_floats = 4 * block_pixels;
        // Few at a time: a length that is not known here would be a call, or a slow instruction for long
        // ones.
        for (int block = 0; block < count / block_pixels; ++block, pixels += block_floats)
          std::memset(pixels, 0, sizeof(float) * block_floats);
      });
    }
  }
  forget_rows();
}

}  // namespace ringsplat
#endif

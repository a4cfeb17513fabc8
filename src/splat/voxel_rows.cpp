#include "splat/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/voxel_rows.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <bit>
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

/// The same for four taps, as most kernels have: all weights stay in registers. `alike`: at one pixel a voxel
/// a tap has one weight in all pixels.
template <int rows, bool alike>
HWY_INLINE void convolve_rows(const BlockSums& in, float* HWY_RESTRICT sums) {
  const Floats d;
  constexpr int taps = 4, block_floats = 4 * block_pixels, step = alike ? int(lanes) : block_floats;
  for (int part = 0; part < step; part += int(lanes)) {
    FloatVector weights[rows][taps];
    for (int row = 0; row < rows; ++row) {
      for (int tap = 0; tap < taps; ++tap) {
        const float* weight = in.weights + tap * tap_floats - row * in.weights_floats;
        weights[row][tap] = alike ? hn::Set(d, *weight) : hn::LoadU(d, weight + part);
      }
    }
    for (int at = part; at < in.blocks * block_floats; at += step) {
      const float* voxels = in.voxels + at;
      auto sum = hn::Zero(d);
      for (int row = 0; row < rows; ++row, voxels += in.row_floats)
        for (int tap = 0; tap < taps; ++tap)
          sum = hn::MulAdd(weights[row][tap], hn::LoadU(d, voxels + tap * in.voxel_floats), sum);
      hn::Store(sum, d, sums + at);
    }
  }
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
namespace {

HWY_EXPORT(ConvolveBlocks);

bool reaches(const SliceBuffer& buffer, const AlignedSlice& slice, int x, int y) {
  return std::any_of(slice.covered.begin(), slice.covered.end(),
                     [&](const AlignedSlice::Offset& at) { return buffer.holds(x + at.x, y + at.y); });
}

/// The first 64 / step bits, a step apart.
std::uint64_t spread(std::uint64_t bits, int step) {
  if (step == 1) return bits;
  bits &= 0xFFFFFFFF;
  bits = (bits | bits << 16) & 0x0000FFFF0000FFFF;
  bits = (bits | bits << 8) & 0x00FF00FF00FF00FF;
  bits = (bits | bits << 4) & 0x0F0F0F0F0F0F0F0F;
  bits = (bits | bits << 2) & 0x3333333333333333;
  bits = (bits | bits << 1) & 0x5555555555555555;
  return step == 2 ? bits : spread(bits, step / 2);
}

/// ORs 64 bits into a row of bits, the first at `place`; those that would lie before place 0 are not set.
void put(std::uint64_t* row, std::uint64_t bits, int place) {
  if (place < 0) {
    row[0] |= bits >> -place;
    return;
  }
  row += place / 64;
  row[0] |= bits << place % 64;
  if (place % 64 > 0 && bits >> (64 - place % 64) != 0) row[1] |= bits >> (64 - place % 64);
}

}  // namespace

void convolve_blocks(const BlockSums& in, float* sums) { HWY_DYNAMIC_DISPATCH(ConvolveBlocks)(in, sums); }

std::uint64_t places_within(std::int64_t x, int step, std::int64_t low, std::int64_t high) {
  constexpr std::uint64_t all = ~std::uint64_t{0};
  const int shift = std::countr_zero(unsigned(step));
  const std::int64_t first = std::max<std::int64_t>((low - x + step - 1) >> shift, 0),
                     last = std::min<std::int64_t>((high - x) >> shift, 63);
  return first <= last ? all << first & all >> (63 - last) : 0;
}

void VoxelRows::prepare(const SliceBuffer& buffer, int left, int reach_x, int reach_y) {
  buffer_ = &buffer;
  left_ = left;
  above_ = reach_y + 1;
  const int inside = (buffer.width + block_pixels - 1) / block_pixels * block_pixels,
            behind = 2 * reach_x + 1 + most_whole_steps;
  words_ = std::size_t(left + inside + behind) / 64 + 1;
  filled_.assign(std::size_t(buffer.height + 2 * reach_y + 1) * words_, 0);
  covered_ = filled_;
  inside_.assign(words_, 0);
  for (int pixel = left; pixel < left + inside; ++pixel) put(inside_.data(), 1, pixel);
  forget_rows();
  sums_ = hwy::AllocateAligned<float>(std::size_t(inside) * 4);
  if (!sums_) throw std::bad_alloc();
}

void VoxelRows::forget_rows() {
  top_ = std::numeric_limits<int>::max();
  bottom_ = std::numeric_limits<int>::min();
}

void VoxelRows::mark(const AlignedSlice& slice, int x, int y, std::uint64_t mask) {
  std::uint64_t *const filled = filled_.data() + at(y), *const covered = covered_.data() + at(y);
  const int step = slice.step_x, columns = 64 / step, window = 2 * slice.reach_x + 2;
  for (int first = 0; first < 64; first += columns) {
    const std::uint64_t anchors = spread(mask >> first, step);
    if (anchors == 0) continue;
    const int place = x + left_ + first * step;
    for (int k = 0; k < step; ++k) put(filled, anchors, place + k);
    // A kernel covers pixels from reach before its anchor to reach + 1 behind it.
    for (int k = 0; k < window; ++k) put(covered, anchors, place - slice.reach_x + k);
  }
  anchor_x_ = x;
  top_ = std::min(top_, y);
  bottom_ = std::max(bottom_, y + 1);
}

/// Voxels whose columns all lie inside are alike.
std::uint64_t VoxelRows::count_drawn(const AlignedSlice& slice, int x, int y, std::uint64_t mask) const {
  const std::uint64_t inside =
      mask & places_within(x, slice.step_x, slice.reach_x, buffer_->width - slice.reach_x - 2);
  const auto x_of_first = [&](std::uint64_t bits) { return x + std::countr_zero(bits) * slice.step_x; };
  const bool rows_inside = y >= slice.reach_y && y + slice.reach_y + 1 < buffer_->height;
  std::uint64_t drawn = 0;
  if (inside != 0 && (rows_inside || reaches(*buffer_, slice, x_of_first(inside), y)))
    drawn = std::uint64_t(std::popcount(inside));
  for (std::uint64_t edge = mask & ~inside; edge != 0; edge &= edge - 1)
    drawn += reaches(*buffer_, slice, x_of_first(edge), y);
  return drawn;
}

VoxelRows::Reaching VoxelRows::reaching(const AlignedSlice& slice, int y) const {
  const int least = y + slice.reach_y - slice.end_row + 1, step = slice.step_y;
  const int steps = std::max(least - top_ + step - 1, 0) / step;
  return {top_ + steps * step, std::min(y + slice.reach_y - slice.first_row + 1, bottom_), step};
}

void VoxelRows::sum(const AlignedSlice& slice, const Reaching& rows, int x, int y, int blocks) {
  const int leftmost = x + slice.reach_x - (slice.taps - 1) * slice.step_x;
  // Steps are powers of two: a remainder of negative numbers too.
  const int phase = (x + slice.reach_x - anchor_x_) & (slice.step_x - 1);
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
      covered_[at(y) + word] = 0;
      for (std::uint64_t bits = first_of_blocks(std::exchange(filled_[at(y) + word], 0)); bits != 0;
           bits &= bits - 1) {
        const int x = int(word) * 64 + std::countr_zero(bits) - left_;
        std::memset(pixel(x, y), 0, sizeof(float) * 4 * block_pixels);
      }
    }
  }
  forget_rows();
}

}  // namespace ringsplat
#endif

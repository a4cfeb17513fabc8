#include "splat/voxel_sum.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/sweep_voxels.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/bit_runs.hpp"
#include "raster/pixel_vectors-inl.hpp"

// Highway compiles this file once for each instruction set; what follows is the same for all.
#ifndef RINGSPLAT_SWEEP_VOXELS_ONCE
#define RINGSPLAT_SWEEP_VOXELS_ONCE
namespace ringsplat {
namespace {

constexpr int block_floats = 4 * block_pixels;

/// A region's composited pixels.
struct ImageRows {
  float* first = nullptr;           ///< RGBA of pixel (0, 0), 64-byte aligned as all rows' are
  std::ptrdiff_t row_floats = 0;    ///< from a row to the next
  float opaque_threshold = 0;       ///< transmittances below it count as 0
  std::uint64_t* opaque = nullptr;  ///< rows of bits: set where a whole pixel block is opaque
};

/// The rows of anchors, a step apart, whose kernels reach a row of pixels.
struct AnchorRows {
  int first, end, step;  ///< anchors' y, from the region's corner
  int count() const { return (end - first + step - 1) / step; }
};

AnchorRows rows_reaching(const VoxelRows& voxels, const AlignedSlice& slice, int y) {
  const int least = y + slice.reach_y - slice.end_row + 1, step = slice.step_y;
  const int steps = std::max(least - voxels.top + step - 1, 0) / step;
  return {voxels.top + steps * step, std::min(y + slice.reach_y - slice.first_row + 1, voxels.bottom), step};
}

/// Sets all four bits of each group of four in which any is set.
std::uint64_t whole_blocks(std::uint64_t bits) {
  bits |= bits >> 1;
  return ((bits | bits >> 2) & 0x1111111111111111) * 15;
}

std::uint64_t* filled_row(const VoxelRows& voxels, int y) {
  return voxels.filled + y * std::ptrdiff_t(voxels.row_words);
}

/// Clears the pixels and bits of the voxels in rows of anchors first … end − 1.
void take_out(const VoxelRows& voxels, int first, int end) {
  for (int y = first; y < end; ++y) {
    std::uint64_t* filled = filled_row(voxels, y);
    for (std::size_t word = 0; word < voxels.row_words; ++word) {
      for_each_bit_run(whole_blocks(std::exchange(filled[word], 0)), [&](int first_pixel, int count) {
        float* pixels = voxels.buffer.origin + y * voxels.buffer.row_floats +
                        std::ptrdiff_t{4} * (int(word) * 64 + first_pixel - voxels.left);
        // Block by block: for a length that is not known here, compilers call memset or use a string
        // instruction that is slow to start.
        for (int block = 0; block < count / block_pixels; ++block, pixels += block_floats)
          std::memset(pixels, 0, sizeof(float) * block_floats);
      });
    }
  }
}

/// Finds the pixel blocks that the kernels of these rows can cover and that are not opaque yet. Each voxel
/// has set the bits of the pixels from its anchor up to the next.
void find_covered(const VoxelRows& voxels, const AlignedSlice& slice, const AnchorRows& rows,
                  const std::uint64_t* opaque, std::uint64_t* covered) {
  const int pixels_before = slice.reach_x - slice.first_column,
            pixels_behind = slice.end_column - slice.reach_x - slice.step_x;
  for (std::size_t word = 0; word < voxels.row_words; ++word) {
    std::uint64_t before = 0, here = 0, behind = 0;
    for (int y = rows.first; y < rows.end; y += rows.step) {
      const std::uint64_t* filled = filled_row(voxels, y) + word;
      before |= filled[-1];
      here |= filled[0];
      behind |= filled[1];
    }
    std::uint64_t bits = here;
    for (int k = 1; k <= pixels_behind; ++k) bits |= here << k | before >> (64 - k);
    for (int k = 1; k <= pixels_before; ++k) bits |= here >> k | behind << (64 - k);
    covered[word] = whole_blocks(bits) & voxels.inside[word] & ~opaque[word];
  }
}

/// Neighbouring pixel blocks of a row, and the voxels whose kernels cover them.
struct BlockSums {
  const float* voxels;            ///< leftmost voxel for the first block, in the topmost row of anchors
  std::ptrdiff_t row_floats;      ///< from one of these rows to the next
  const float* weights;           ///< of the topmost row
  std::ptrdiff_t weights_floats;  ///< from a row of anchors' weights back to the next row's
  int rows, taps, voxel_floats;   ///< voxel_floats: from a voxel to the next
  int blocks;
};

BlockSums block_sums(const VoxelRows& voxels, const AlignedSlice& slice, const AnchorRows& rows, int x, int y,
                     int blocks) {
  const int leftmost = x + slice.first_tap_x;
  // Steps are powers of two, so this is the remainder of negative numbers too.
  const int phase = (x + slice.reach_x - int(voxels.x & (slice.step_x - 1))) & (slice.step_x - 1);
  const std::ptrdiff_t row_weights = std::ptrdiff_t{slice.taps} * tap_floats;
  const int row = y - rows.first + slice.reach_y;
  return {voxels.buffer.origin + rows.first * voxels.buffer.row_floats + std::ptrdiff_t{4} * leftmost,
          rows.step * voxels.buffer.row_floats,
          slice.weights.data() + row * row_weights + std::ptrdiff_t{4} * phase,
          rows.step * row_weights,
          rows.count(),
          slice.taps,
          4 * slice.step_x,
          blocks};
}

}  // namespace
}  // namespace ringsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

constexpr int parts = block_floats / int(lanes);
using BlockOfSums = FloatVector[parts];

/// Each block has sums of its own, so that no addition waits for the one before.
template <int blocks, class Take>
HWY_INLINE void convolve_some(const BlockSums& in, int first, const Take& take) {
  const Floats d;
  BlockOfSums sums[blocks];
  for (auto& block : sums)
    for (auto& part : block) part = hn::Zero(d);
  for (int row = 0; row < in.rows; ++row) {
    for (int tap = 0; tap < in.taps; ++tap) {
      const float* weight = in.weights + tap * tap_floats - row * in.weights_floats;
      const float* voxels = in.voxels + first * block_floats + row * in.row_floats + tap * in.voxel_floats;
      for (int block = 0; block < blocks; ++block)
        for (int i = 0; i < parts; ++i)
          sums[block][i] =
              fused(hn::LoadU(d, weight + i * int(lanes)),
                    hn::LoadU(d, voxels + block * block_floats + i * int(lanes)), sums[block][i]);
    }
  }
  for (int block = 0; block < blocks; ++block) take(first + block, sums[block]);
}

template <class Take>
HWY_INLINE void convolve(const BlockSums& in, const Take& take) {
  int block = 0;
  for (; block + 2 <= in.blocks; block += 2) convolve_some<2>(in, block, take);
  if (block < in.blocks) convolve_some<1>(in, block, take);
}

/// Returns whether all of the image's pixels are opaque now.
HWY_INLINE bool composite_block(const BlockOfSums& sums, float opaque, float* image) {
  const Floats d;
  auto all = hn::FirstN(d, lanes);
  for (int i = 0; i < parts; ++i)
    all = hn::And(all, composite_pixels(sums[i], hn::Set(d, opaque), image + i * int(lanes)));
  return hn::AllTrue(d, all);
}

/// Calls use(rows of anchors, x, y, blocks) for each run of covered pixel blocks, row by row. Takes the
/// voxels of a row of anchors out as soon as it reaches no further rows, while they are still in the cache.
template <class Use>
HWY_INLINE void sweep(const VoxelRows& voxels, const AlignedSlice& slice, std::uint64_t* opaque,
                      std::uint64_t* covered, const Use& use) {
  const int begin = std::max(voxels.top - slice.reach_y, 0),
            end = std::min(voxels.bottom + slice.reach_y + 1, voxels.buffer.height);
  int taken_out = voxels.top;
  for (int y = begin; y < end; ++y) {
    const AnchorRows rows = rows_reaching(voxels, slice, y);
    // Rows of anchors beyond the last one hold no voxels.
    const int done = std::min(rows.first, voxels.bottom);
    if (done > taken_out) take_out(voxels, std::exchange(taken_out, done), done);
    find_covered(voxels, slice, rows, opaque + std::size_t(y) * voxels.row_words, covered);
    int x = 0, x_end = 0;  // run of covered pixels that is not summed yet
    for (std::size_t word = 0; word < voxels.row_words; ++word) {
      for_each_bit_run(covered[word], [&](int first, int count) {
        first += int(word) * 64 - voxels.left;
        // Summing one uncovered block costs less than beginning a new run.
        if (x < x_end && first - x_end > block_pixels) {
          use(rows, x, y, (x_end - x) / block_pixels);
          x_end = x;
        }
        if (x == x_end) x = first;
        x_end = first + count;
      });
    }
    if (x < x_end) use(rows, x, y, (x_end - x) / block_pixels);
  }
  take_out(voxels, taken_out, voxels.bottom);
}

/// Sums in each pixel the kernels of the voxels round it, so that a pixel is written once instead of once for
/// each voxel; composites the sums behind the image, except behind opaque pixel blocks; and takes the voxels
/// out. `covered` is scratch for a row of bits. Returns how many pixels it went through.
///
/// The image has the bits that draw_splats, given the voxels row by row, and composite_row would make.
std::uint64_t CompositeVoxels(const VoxelRows& voxels, const AlignedSlice& slice, const ImageRows& image,
                              std::uint64_t* covered) {
  std::uint64_t composited = 0;
  sweep(voxels, slice, image.opaque, covered, [&](const AnchorRows& rows, int x, int y, int blocks) {
    float* to = image.first + y * image.row_floats + std::ptrdiff_t{4} * x;
    std::uint64_t* opaque = image.opaque + std::size_t(y) * voxels.row_words;
    composited += std::uint64_t(blocks) * block_pixels;
    convolve(block_sums(voxels, slice, rows, x, y, blocks), [&](int block, BlockOfSums& sums) {
      if (!composite_block(sums, image.opaque_threshold, to + block * block_floats)) return;
      const int pixel = voxels.left + x + block * block_pixels;
      opaque[pixel / 64] |= std::uint64_t{15} << pixel % 64;
    });
  });
  return composited;
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(CompositeVoxels);

std::uint64_t VoxelSum::composite() {
  if (rows_.top >= rows_.bottom) return 0;
  std::uint64_t composited = 0;
  if (reached_ || image_->touched()) {
    const ImageRows image{image_->pixels(), image_->row_floats(), image_->opaque_threshold(),
                          image_->opaque_bits(rows_.row_words)};
    composited = HWY_DYNAMIC_DISPATCH(CompositeVoxels)(rows_, slice_, image, covered_.data());
    image_->slices_composited();
  } else {
    take_out(rows_, rows_.top, rows_.bottom);
  }
  rows_.top = VoxelRows().top;
  rows_.bottom = VoxelRows().bottom;
  reached_ = false;
  return composited;
}

}  // namespace ringsplat
#endif

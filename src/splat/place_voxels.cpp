#include "splat/voxel_kernels.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/place_voxels.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "raster/pixel_vectors-inl.hpp"

// Highway compiles this file once for each instruction set; what follows is the same for all.
#ifndef RINGSPLAT_PLACE_VOXELS_ONCE
#define RINGSPLAT_PLACE_VOXELS_ONCE
namespace ringsplat {
namespace {

/// Spreads the first 64 / step bits so that they are a step apart. A step is 2 or 4.
std::uint64_t spread(std::uint64_t bits, int step) {
  bits &= 0xFFFFFFFF;
  bits = (bits | bits << 16) & 0x0000FFFF0000FFFF;
  bits = (bits | bits << 8) & 0x00FF00FF00FF00FF;
  bits = (bits | bits << 4) & 0x0F0F0F0F0F0F0F0F;
  bits = (bits | bits << 2) & 0x3333333333333333;
  bits = (bits | bits << 1) & 0x5555555555555555;
  return step == 2 ? bits : spread(bits, step / 2);
}

bool reaches(const SliceBuffer& buffer, const AlignedSlice& slice, std::int64_t x, std::int64_t y) {
  return std::any_of(slice.covered.begin(), slice.covered.end(), [&](const AlignedSlice::Offset& at) {
    return buffer.holds(int(x) + at.x, int(y) + at.y);
  });
}

/// Counts the voxels of a block at the region's edge that reach one of its pixels. Those whose windows'
/// columns all lie inside (`inside`) are alike and looked at once; the others one by one.
std::uint64_t count_at_edge(const SliceBuffer& buffer, const AlignedSlice& slice, std::int64_t x,
                            std::int64_t y, std::uint64_t mask, std::uint64_t inside) {
  const auto x_of_first = [&](std::uint64_t bits) { return x + std::countr_zero(bits) * slice.step_x; };
  std::uint64_t drawn = 0;
  if (inside != 0 && reaches(buffer, slice, x_of_first(inside), y))
    drawn = std::uint64_t(std::popcount(inside));
  for (std::uint64_t edge = mask & ~inside; edge != 0; edge &= edge - 1)
    drawn += reaches(buffer, slice, x_of_first(edge), y);
  return drawn;
}

}  // namespace
}  // namespace ringsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// An opacity times the footprint's weight, as in a splat; 0 for what no footprint gives.
HWY_INLINE float weighted(float opacity, double weight) {
  const auto product = static_cast<float>(static_cast<double>(opacity) * weight);
  return std::abs(product) < largest_coefficient ? product : 0.0F;
}

using Pixel = hn::Vec<FourFloats>;
using FourInts = hn::Full128<std::int32_t>;
using SixteenBytes = hn::Full128<std::uint8_t>;

/// Loads a voxel: its colour, in which 65535 is 1, and its opacity. Reads six bytes beyond a FloatVoxel.
HWY_INLINE Pixel load(const FloatVoxel* voxel) {
  const FourFloats d;
  const FourInts i;
  constexpr std::uint8_t none = 0x80;
  HWY_ALIGN constexpr std::uint8_t orders[2][16] = {
      {none, none, 4, 5, none, none, 6, 7, none, none, 8, 9, 0, 1, 2, 3},
      {4, 5, none, none, 6, 7, none, none, 8, 9, none, none, 0, 1, 2, 3}};
  const auto order = hn::Load(SixteenBytes(), orders[std::endian::native == std::endian::little]);
  const auto bytes = hn::LoadU(SixteenBytes(), reinterpret_cast<const std::uint8_t*>(voxel));
  const auto words = hn::BitCast(i, hn::TableLookupBytesOr0(bytes, order));
  return hn::IfThenElse(hn::FirstN(d, 3), hn::ConvertTo(d, words), hn::BitCast(d, words));
}
HWY_INLINE Pixel load(const HalfVoxel* voxel) {
  const FourFloats d;
  const hn::Rebind<hwy::float16_t, FourFloats> halves;
  const hn::Rebind<std::uint16_t, FourFloats> words;
  const auto rgba = hn::PromoteTo(d, hn::BitCast(halves, hn::LoadU(words, voxel->rgba)));
  const auto inside = hn::Min(hn::Max(hn::Zero(d), rgba), hn::Set(d, 1.0F));
  const auto quantised =
      hn::ConvertTo(FourInts(), hn::Add(hn::Mul(inside, hn::Set(d, 65535.0F)), hn::Set(d, 0.5F)));
  return hn::IfThenElse(hn::FirstN(d, 3), hn::ConvertTo(d, quantised), rgba);
}
HWY_INLINE Pixel load(const ByteVoxel* voxel) {
  const FourFloats d;
  const hn::Rebind<std::uint8_t, FourFloats> bytes;
  const auto rgba = hn::ConvertTo(d, hn::PromoteTo(FourInts(), hn::LoadU(bytes, voxel->rgba)));
  const auto colours = hn::Mul(rgba, hn::Set(d, 257.0F)), opacities = hn::Div(rgba, hn::Set(d, 255.0F));
  return hn::IfThenElse(hn::FirstN(d, 3), colours, opacities);
}

HWY_INLINE void place_one(Pixel voxel, double weight, int steps, float* pixels) {
  const FourFloats d;
  const float opacity = weighted(hn::ExtractLane(voxel, 3), weight);
  const auto premultiplied = hn::Mul(voxel, hn::Set(d, opacity * (1.0F / 65535.0F)));
  const auto colour = hn::IfThenElse(hn::FirstN(d, 3), premultiplied, hn::Set(d, opacity));
  for (int copy = 0; copy < steps; ++copy) store_pixel(colour, pixels + std::ptrdiff_t{4} * copy);
}

/// `row`: pixel of the mask's bit 0, inside the buffer or not. `last`: no byte may be read beyond these
/// voxels.
template <class Voxel>
HWY_INLINE void place_row(int steps, double weight, std::uint64_t mask, const Voxel* voxels, bool last,
                          float* row) {
  const auto to = [&] { return row + std::ptrdiff_t{4} * (std::countr_zero(mask) * steps); };
  const std::uint64_t careful = last ? std::bit_floor(mask) : 0;
  for (; mask != careful; mask &= mask - 1, ++voxels) place_one(load(voxels), weight, steps, to());
  if (careful == 0) return;
  HWY_ALIGN std::uint8_t copy[16] = {};
  std::memcpy(copy, voxels, sizeof(Voxel));
  place_one(load(reinterpret_cast<const Voxel*>(copy)), weight, steps, to());
}

/// Sets 64 bits' ones in a row of bits from `place` on, but none before place 0.
HWY_INLINE void put(std::uint64_t* row, std::uint64_t bits, std::int64_t place) {
  if (place < 0) {
    row[0] |= bits >> -place;
    return;
  }
  row += place / 64;
  row[0] |= bits << place % 64;
  if (place % 64 > 0 && bits >> (64 - place % 64) != 0) row[1] |= bits >> (64 - place % 64);
}

/// Sets the bits of the pixels that hold the voxels.
HWY_INLINE void mark(std::uint64_t* filled, std::uint64_t mask, std::int64_t place, int steps) {
  if (steps == 1) {
    put(filled, mask, place);
    return;
  }
  for (int first = 0; first < 64; first += 64 / steps)
    if (const std::uint64_t anchors = spread(mask >> first, steps); anchors != 0)
      for (int k = 0; k < steps; ++k) put(filled, anchors, place + first * steps + k);
}

/// How many of the voxels have a weight above zero in the region.
HWY_INLINE std::uint64_t count_drawn(const AlignedSlice& slice, const SliceBuffer& buffer, std::int64_t x,
                                     std::int64_t y, std::uint64_t mask) {
  const std::uint64_t inside =
      mask & places_within(x, slice.step_x, slice.reach_x, buffer.width - slice.reach_x - 2);
  const bool rows_inside = y >= slice.reach_y && y + slice.reach_y + 1 < buffer.height;
  if (rows_inside && inside == mask) return std::uint64_t(std::popcount(mask));
  return count_at_edge(buffer, slice, x, y, mask, inside);
}

template <int known_steps, class Voxel>
HWY_INLINE DrawnBlocks place(const AlignedSlice& slice, VoxelRows& to, const VoxelBlocks<Voxel>& blocks,
                             std::uint64_t most) {
  const int steps = known_steps > 0 ? known_steps : slice.step_x;
  // Windows that meet the region have their anchor at most reach + 1 before it, or reach behind it.
  const std::int64_t least_x = -slice.reach_x - 1, most_x = to.buffer.width + slice.reach_x - 1,
                     least_y = -slice.reach_y - 1, most_y = to.buffer.height + slice.reach_y - 1;
  DrawnBlocks placed;
  std::uint64_t seen = 0;
  while (placed.blocks < blocks.count && seen < most) {
    VoxelBlock block;
    std::memcpy(&block, blocks.blocks + placed.blocks * sizeof block, sizeof block);
    const bool last = ++placed.blocks == blocks.count;
    const Voxel* voxels = blocks.voxels + seen;
    seen += std::uint64_t(std::popcount(block.mask));
    const std::int64_t x = to.x + std::int64_t{steps} * block.first,
                       y = to.y + std::int64_t{slice.step_y} * block.row;
    if (y < least_y || y > most_y) continue;
    const std::uint64_t within = block.mask & places_within(x, steps, least_x, most_x);
    if (within == 0) continue;
    voxels += std::popcount(block.mask & ((within & -within) - 1));
    place_row(steps, slice.opacity_weight, within, voxels, last,
              to.buffer.origin + y * to.buffer.row_floats + 4 * x);
    mark(to.filled + y * std::ptrdiff_t(to.row_words), within, x + to.left, steps);
    placed.counts.drawn += count_drawn(slice, to.buffer, x, y, within);
    to.top = std::min(to.top, int(y));
    to.bottom = std::max(to.bottom, int(y) + 1);
  }
  placed.counts.clipped = seen - placed.counts.drawn;
  return placed;
}

DrawnBlocks PlaceVoxels(const AlignedSlice& slice, VoxelRows& to, const AnyVoxelBlocks& any,
                        std::uint64_t most) {
  return std::visit(
      [&](const auto& blocks) {
        return slice.step_x == 1 ? place<1>(slice, to, blocks, most) : place<0>(slice, to, blocks, most);
      },
      any);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(PlaceVoxels);

DrawnBlocks place_voxels(const AlignedSlice& slice, VoxelRows& to, const AnyVoxelBlocks& blocks,
                         std::uint64_t most) {
  return HWY_DYNAMIC_DISPATCH(PlaceVoxels)(slice, to, blocks, most);
}

}  // namespace ringsplat
#endif

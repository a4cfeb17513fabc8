#include "splat/place_voxels.hpp"

#include "splat/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/place_voxels.cpp"
#include <hwy/foreach_target.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "splat/pixel_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// As a footprint's weight makes a splat's; 0 for what no footprint gives.
HWY_INLINE float weighted(float opacity, double weight) {
  const auto product = static_cast<float>(static_cast<double>(opacity) * weight);
  return std::abs(product) < largest_coefficient ? product : 0.0F;
}

#if RINGSPLAT_ONE_BY_ONE

template <class Voxel>
void place(const AlignedSlice& slice, std::uint64_t mask, const Voxel* voxels, int x, float* row) {
  for (; mask != 0; mask &= mask - 1, ++voxels) {
    const VoxelColour voxel = unpack(*voxels);
    const auto colour = premultiply(&voxel.red, weighted(voxel.opacity, slice.opacity_weight));
    float* pixels = row + std::ptrdiff_t{4} * (x + std::countr_zero(mask) * slice.step_x);
    for (int copy = 0; copy < slice.step_x; ++copy, pixels += 4) store_pixel(colour, pixels);
  }
}

#else

using Pixel = hn::Vec<FourFloats>;
using FourInts = hn::Full128<std::int32_t>;
using SixteenBytes = hn::Full128<std::uint8_t>;

/// Reads a voxel's colour, 65535 = 1, and its opacity.
template <class Voxel>
class Reader;

/// Reads six bytes beyond the voxel.
template <>
class Reader<FloatVoxel> {
 public:
  HWY_INLINE Reader() {
    constexpr std::uint8_t low = std::endian::native == std::endian::little ? 0 : 2, none = 0x80;
    HWY_ALIGN std::uint8_t order[16];
    std::memset(order, none, sizeof order);
    for (std::size_t channel = 0; channel < 3; ++channel)
      for (std::size_t byte = 0; byte < 2; ++byte)
        order[4 * channel + low + byte] = std::uint8_t(4 + 2 * channel + byte);
    for (std::size_t byte = 0; byte < 4; ++byte) order[12 + byte] = std::uint8_t(byte);
    order_ = hn::Load(SixteenBytes(), order);
  }
  HWY_INLINE Pixel read(const FloatVoxel* voxel) const {
    const FourFloats d;
    const FourInts i;
    const auto bytes = hn::LoadU(SixteenBytes(), reinterpret_cast<const std::uint8_t*>(voxel));
    const auto words = hn::BitCast(i, hn::TableLookupBytesOr0(bytes, order_));
    return hn::IfThenElse(hn::FirstN(d, 3), hn::ConvertTo(d, words), hn::BitCast(d, words));
  }

 private:
  hn::Vec<SixteenBytes> order_;
};

template <>
class Reader<HalfVoxel> {
 public:
  HWY_INLINE Pixel read(const HalfVoxel* voxel) const {
    const FourFloats d;
    const hn::Rebind<hwy::float16_t, FourFloats> halves;
    const hn::Rebind<std::uint16_t, FourFloats> words;
    const auto rgba = hn::PromoteTo(d, hn::BitCast(halves, hn::LoadU(words, voxel->rgba)));
    const auto inside = hn::Min(hn::Max(hn::Zero(d), rgba), hn::Set(d, 1.0F));
    const auto quantised =
        hn::ConvertTo(FourInts(), hn::Add(hn::Mul(inside, hn::Set(d, 65535.0F)), hn::Set(d, 0.5F)));
    return hn::IfThenElse(hn::FirstN(d, 3), hn::ConvertTo(d, quantised), rgba);
  }
};

template <>
class Reader<ByteVoxel> {
 public:
  HWY_INLINE Pixel read(const ByteVoxel* voxel) const {
    const FourFloats d;
    const hn::Rebind<std::uint8_t, FourFloats> bytes;
    const auto rgba = hn::ConvertTo(d, hn::PromoteTo(FourInts(), hn::LoadU(bytes, voxel->rgba)));
    const auto colours = hn::Mul(rgba, hn::Set(d, 257.0F)), opacities = hn::Div(rgba, hn::Set(d, 255.0F));
    return hn::IfThenElse(hn::FirstN(d, 3), colours, opacities);
  }
};

HWY_INLINE void place_one(Pixel voxel, double weight, int steps, float* pixels) {
  const FourFloats d;
  const float opacity = weighted(hn::ExtractLane(voxel, 3), weight);
  const auto premultiplied = hn::Mul(voxel, hn::Set(d, opacity * (1.0F / 65535.0F)));
  const auto colour = hn::IfThenElse(hn::FirstN(d, 3), premultiplied, hn::Set(d, opacity));
  for (int copy = 0; copy < steps; ++copy) store_pixel(colour, pixels + std::ptrdiff_t{4} * copy);
}

/// `steps`: the slice's step_x, known to the compiler where it matters.
template <class Voxel>
HWY_INLINE void place_steps(int steps, double weight, std::uint64_t mask, const Voxel* voxels, int x,
                            float* row) {
  const Reader<Voxel> reader;
  const auto to = [&] { return row + std::ptrdiff_t{4} * (x + std::countr_zero(mask) * steps); };
  for (std::uint64_t rest = mask & (mask - 1); rest != 0; mask = rest, rest &= rest - 1, ++voxels)
    place_one(reader.read(voxels), weight, steps, to());
  // What a reader may read beyond a voxel is there only before the last.
  HWY_ALIGN std::uint8_t last[16] = {};
  std::memcpy(last, voxels, sizeof(Voxel));
  place_one(reader.read(reinterpret_cast<const Voxel*>(last)), weight, steps, to());
}

template <class Voxel>
HWY_INLINE void place(const AlignedSlice& slice, std::uint64_t mask, const Voxel* voxels, int x, float* row) {
  if (slice.step_x == 1)
    place_steps(1, slice.opacity_weight, mask, voxels, x, row);
  else
    place_steps(slice.step_x, slice.opacity_weight, mask, voxels, x, row);
}

#endif

void PlaceFloats(const AlignedSlice& slice, std::uint64_t mask, const FloatVoxel* voxels, int x, float* row) {
  place(slice, mask, voxels, x, row);
}
void PlaceHalves(const AlignedSlice& slice, std::uint64_t mask, const HalfVoxel* voxels, int x, float* row) {
  place(slice, mask, voxels, x, row);
}
void PlaceBytes(const AlignedSlice& slice, std::uint64_t mask, const ByteVoxel* voxels, int x, float* row) {
  place(slice, mask, voxels, x, row);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(PlaceFloats);
HWY_EXPORT(PlaceHalves);
HWY_EXPORT(PlaceBytes);

void place_voxels(const AlignedSlice& slice, std::uint64_t mask, const FloatVoxel* voxels, int x,
                  float* row) {
  HWY_DYNAMIC_DISPATCH(PlaceFloats)(slice, mask, voxels, x, row);
}
void place_voxels(const AlignedSlice& slice, std::uint64_t mask, const HalfVoxel* voxels, int x, float* row) {
  HWY_DYNAMIC_DISPATCH(PlaceHalves)(slice, mask, voxels, x, row);
}
void place_voxels(const AlignedSlice& slice, std::uint64_t mask, const ByteVoxel* voxels, int x, float* row) {
  HWY_DYNAMIC_DISPATCH(PlaceBytes)(slice, mask, voxels, x, row);
}

}  // namespace ringsplat
#endif

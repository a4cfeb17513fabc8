#include "base/vector_config.hpp"
#include "splat/voxel_run.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/pack_voxels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <bit>

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FourFloats = hn::Full128<float>;
using FourInts = hn::Full128<std::int32_t>;
/// A voxel's opacity, then its colour in 3 × 16 bits.
void PackFloats(const float* rgba, std::size_t count, FloatVoxel* voxels) {
  const FourFloats d;
  const FourInts i;
  const hn::Full128<std::uint8_t> bytes;
  constexpr std::uint8_t low = std::endian::native == std::endian::little ? 0 : 2, none = 0x80;
  HWY_ALIGN constexpr std::uint8_t order[16] = {12,      13,      14,   15,   low,  1 + low, 4 + low, 5 + low,
                                                8 + low, 9 + low, none, none, none, none,    none,    none};
  HWY_ALIGN std::uint8_t packed[16];
  for (std::size_t k = 0; k < count; ++k) {
    const auto voxel = hn::LoadU(d, rgba + 4 * k);
    const auto inside = hn::Min(hn::Max(hn::Zero(d), voxel), hn::Set(d, 1.0F));
    const auto quantised = hn::ConvertTo(i, hn::Add(hn::Mul(inside, hn::Set(d, 65535.0F)), hn::Set(d, 0.5F)));
    const auto words = hn::IfThenElse(hn::FirstN(i, 3), quantised, hn::BitCast(i, voxel));
    hn::Store(hn::TableLookupBytes(hn::BitCast(bytes, words), hn::Load(bytes, order)), bytes, packed);
    std::memcpy(voxels + k, packed, sizeof(FloatVoxel));
  }
}

#if HWY_TARGET == HWY_EMU128

/// Rounds 0 and numbers from 2⁻¹²⁶ to 65504 to nearest even (Giesen 2012, "Float->half variants"). Highway's
/// own emulation cuts off.
HWY_INLINE std::uint16_t to_half(float value) {
  // The sum has the half's last place, so that adding rounds.
  if (value < 0x1p-14F)
    return static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(value + 0.5F) -
                                      std::bit_cast<std::uint32_t>(0.5F));
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t odd = bits >> 13 & 1;
  return static_cast<std::uint16_t>((bits - (std::uint32_t{127 - 15} << 23) + 0xfff + odd) >> 13);
}

void PackHalves(const float* rgba, std::size_t count, HalfVoxel* voxels) {
  for (std::size_t i = 0; i < 4 * count; ++i) voxels[i / 4].rgba[i % 4] = to_half(rgba[i]);
}

#else

void PackHalves(const float* rgba, std::size_t count, HalfVoxel* voxels) {
  const FourFloats d;
  const hn::Rebind<hwy::float16_t, FourFloats> halves;
  const hn::Rebind<std::uint16_t, FourFloats> words;
  for (std::size_t k = 0; k < count; ++k) {
    const auto narrow = hn::DemoteTo(halves, hn::LoadU(d, rgba + 4 * k));
    hn::StoreU(hn::BitCast(words, narrow), words, voxels[k].rgba);
  }
}

#endif

void PackBytes(const float* rgba, std::size_t count, ByteVoxel* voxels) {
  const FourFloats d;
  const FourInts i;
  const hn::Rebind<std::uint8_t, FourFloats> bytes;
  for (std::size_t k = 0; k < count; ++k) {
    const auto scaled = hn::Add(hn::Mul(hn::LoadU(d, rgba + 4 * k), hn::Set(d, 255.0F)), hn::Set(d, 0.5F));
    hn::StoreU(hn::DemoteTo(bytes, hn::ConvertTo(i, scaled)), bytes, voxels[k].rgba);
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(PackFloats);
HWY_EXPORT(PackHalves);
HWY_EXPORT(PackBytes);

void pack(const float* rgba, std::size_t count, FloatVoxel* voxels) {
  HWY_DYNAMIC_DISPATCH(PackFloats)(rgba, count, voxels);
}
void pack(const float* rgba, std::size_t count, HalfVoxel* voxels) {
  HWY_DYNAMIC_DISPATCH(PackHalves)(rgba, count, voxels);
}
void pack(const float* rgba, std::size_t count, ByteVoxel* voxels) {
  HWY_DYNAMIC_DISPATCH(PackBytes)(rgba, count, voxels);
}

}  // namespace ringsplat
#endif

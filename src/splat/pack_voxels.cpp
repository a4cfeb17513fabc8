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
using Voxel = hn::Vec<FourFloats>;

/// Packs a voxel into the first 10 bytes: its opacity, then its colour in 3 × 16 bits.
class FloatPacker {
 public:
  HWY_INLINE FloatPacker() {
    constexpr std::uint8_t low = std::endian::native == std::endian::little ? 0 : 2, none = 0x80;
    HWY_ALIGN constexpr std::uint8_t order[16] = {
        12, 13, 14, 15, low, 1 + low, 4 + low, 5 + low, 8 + low, 9 + low, none, none, none, none, none, none};
    order_ = hn::Load(hn::Full128<std::uint8_t>(), order);
  }
  HWY_INLINE hn::Vec<hn::Full128<std::uint8_t>> pack(Voxel rgba) const {
    const FourFloats d;
    const FourInts i;
    const auto inside = hn::Min(hn::Max(hn::Zero(d), rgba), hn::Set(d, 1.0F));
    const auto quantised = hn::ConvertTo(i, hn::Add(hn::Mul(inside, hn::Set(d, 65535.0F)), hn::Set(d, 0.5F)));
    const auto colours = hn::FirstN(i, 3);
    const auto words = hn::IfThenElse(colours, quantised, hn::BitCast(i, rgba));
    return hn::TableLookupBytes(hn::BitCast(hn::Full128<std::uint8_t>(), words), order_);
  }

 private:
  hn::Vec<hn::Full128<std::uint8_t>> order_;
};

void PackFloats(const float* rgba, std::size_t count, FloatVoxel* voxels) {
  if (count == 0) return;
  const hn::Full128<std::uint8_t> bytes;
  const FourFloats d;
  const FloatPacker packer;
  auto* out = reinterpret_cast<std::uint8_t*>(voxels);
  // A store reaches beyond its voxel, and the next one overwrites that.
  for (std::size_t k = 0; k + 1 < count; ++k)
    hn::StoreU(packer.pack(hn::LoadU(d, rgba + 4 * k)), bytes, out + k * sizeof(FloatVoxel));
  HWY_ALIGN std::uint8_t last[16];
  hn::Store(packer.pack(hn::LoadU(d, rgba + 4 * (count - 1))), bytes, last);
  std::memcpy(out + (count - 1) * sizeof(FloatVoxel), last, sizeof(FloatVoxel));
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

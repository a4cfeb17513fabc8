// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_PIXEL_VECTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_PIXEL_VECTORS_INL
#undef RINGSPLAT_PIXEL_VECTORS_INL
#else
#define RINGSPLAT_PIXEL_VECTORS_INL
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// As many floats as the processor adds at once, but at most four pixels.
using Floats = hn::CappedTag<float, 16>;
using FloatVector = hn::Vec<Floats>;
using FourFloats = hn::Full128<float>;
using Colour = FloatVector;
inline constexpr std::size_t lanes = HWY_LANES(float) < 16 ? HWY_LANES(float) : 16;
inline constexpr std::size_t pixels_a_vector = lanes / 4;

/// a · b + c, rounded once. Emulated vectors round the product, too.
template <class V>
HWY_INLINE V fused(V a, V b, V c) {
#if HWY_TARGET == HWY_EMU128
  for (std::size_t i = 0; i < sizeof c.raw / sizeof c.raw[0]; ++i)
    c.raw[i] = std::fma(a.raw[i], b.raw[i], c.raw[i]);
  return c;
#else
  return hn::MulAdd(a, b, c);
#endif
}

/// Spreads one value for each pixel over RGBA pixels: get<part>() takes the part-th quarter of `lanes` values
/// and repeats each four times.
class Spread {
 public:
  HWY_INLINE Spread() {
    HWY_ALIGN std::int32_t pick[4][lanes];
    for (std::size_t part = 0; part < 4; ++part) {
      for (std::size_t i = 0; i < lanes; ++i)
        pick[part][i] = static_cast<std::int32_t>(part * pixels_a_vector + i / 4);
      indices_[part] = hn::SetTableIndices(Floats(), pick[part]);
    }
  }
  template <int part>
  HWY_INLINE FloatVector get(FloatVector values) const {
    return hn::TableLookupLanes(values, indices_[part]);
  }

 private:
  decltype(hn::SetTableIndices(Floats(), static_cast<const std::int32_t*>(nullptr))) indices_[4];
};

/// Composites a slice's sums behind pixels of the image. Returns which of these are opaque now.
HWY_INLINE hn::Mask<Floats> composite_pixels(FloatVector sums, FloatVector opaque, float* image) {
  const Floats d;
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0F);
  const auto opacity = hn::Min(hn::Max(hn::Broadcast<3>(sums), zero), one);
  const auto added = hn::Min(hn::Max(sums, zero), opacity);
  const auto behind = hn::Load(d, image);
  const auto left = hn::Sub(one, hn::Broadcast<3>(behind));
  const auto transmittance = hn::IfThenZeroElse(hn::Lt(left, opaque), left);
  const auto after = fused(transmittance, added, behind);
  hn::Store(after, d, image);
  return hn::Lt(hn::Sub(one, hn::Broadcast<3>(after)), opaque);
}

HWY_INLINE void add_to(float* pixels, FloatVector weights, FloatVector colour) {
  const Floats d;
  hn::StoreU(fused(weights, colour, hn::LoadU(d, pixels)), d, pixels);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_LANES_INL
#undef RINGSPLAT_LANES_INL
#else
#define RINGSPLAT_LANES_INL
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

/// Numbers of a few pixels at once: sixteen with AVX-512, eight with AVX2, four elsewhere. All do the same
/// operations in the same order, so a pixel has the same bits. Elsewhere 16-bit numbers are multiplied as
/// 32-bit ones: NEON has no sums of neighbouring products, and emulated vectors round upper halves otherwise.
#define RINGSPLAT_LANES_PAIRS (HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2)
#define RINGSPLAT_LANES_PATCHES (HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3)

// Inlined into one function, painters with emulated vectors take minutes to compile. Highway compiles these
// last.
#if HWY_TARGET == HWY_EMU128
#undef HWY_INLINE
#define HWY_INLINE inline
#endif

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Df = hn::CappedTag<float, 16>;
using Di = hn::Rebind<std::int32_t, Df>;
using Dw = hn::Repartition<std::int16_t, Df>;
using F = hn::Vec<Df>;
using I = hn::Vec<Di>;
using M = hn::Mask<Df>;
inline constexpr int lanes = int(HWY_LANES(float) < 16 ? HWY_LANES(float) : 16);
inline constexpr int tile_width = 4, tile_height = lanes / 4;

HWY_INLINE F set(float x) { return hn::Set(Df(), x); }
HWY_INLINE I set_int(std::int32_t x) { return hn::Set(Di(), x); }
/// Rounded once.
HWY_INLINE F fma(F a, F b, F c) {
#if HWY_TARGET == HWY_EMU128
  for (int l = 0; l < lanes; ++l) c.raw[l] = std::fma(a.raw[l], b.raw[l], c.raw[l]);
  return c;
#else
  return hn::MulAdd(a, b, c);
#endif
}
HWY_INLINE F add(F a, F b) { return hn::Add(a, b); }
HWY_INLINE F sub(F a, F b) { return hn::Sub(a, b); }
HWY_INLINE F mul(F a, F b) { return hn::Mul(a, b); }
HWY_INLINE F div(F a, F b) { return hn::Div(a, b); }
/// The second when one is not a number.
#if RINGSPLAT_LANES_PAIRS
HWY_INLINE F min(F a, F b) { return hn::Min(a, b); }
HWY_INLINE F max(F a, F b) { return hn::Max(a, b); }
#else
HWY_INLINE F min(F a, F b) { return hn::IfThenElse(hn::Lt(a, b), a, b); }
HWY_INLINE F max(F a, F b) { return hn::IfThenElse(hn::Gt(a, b), a, b); }
#endif
HWY_INLINE F abs(F a) { return hn::Abs(a); }
HWY_INLINE F floor(F a) { return hn::Floor(a); }
HWY_INLINE F root(F a) { return hn::Sqrt(a); }
HWY_INLINE F load(const float* p) { return hn::LoadU(Df(), p); }
HWY_INLINE void store(F a, float* p) { hn::StoreU(a, Df(), p); }
HWY_INLINE I load(const std::int32_t* p) { return hn::LoadU(Di(), p); }
HWY_INLINE void store_ints(I a, std::int32_t* p) { hn::StoreU(a, Di(), p); }
/// To the nearest whole number, ties to even; a must be within the range.
HWY_INLINE I to_int(F a) { return hn::NearestInt(a); }
HWY_INLINE F to_float(I a) { return hn::ConvertTo(Df(), a); }
HWY_INLINE I bits_of(F a) { return hn::BitCast(Di(), a); }
HWY_INLINE F from_bits(I a) { return hn::BitCast(Df(), a); }
HWY_INLINE I add(I a, I b) { return hn::Add(a, b); }
HWY_INLINE I sub(I a, I b) { return hn::Sub(a, b); }
HWY_INLINE I mul(I a, I b) { return hn::Mul(a, b); }
HWY_INLINE I both(I a, I b) { return hn::And(a, b); }
HWY_INLINE I either(I a, I b) { return hn::Or(a, b); }
HWY_INLINE I min(I a, I b) { return hn::Min(a, b); }
HWY_INLINE I max(I a, I b) { return hn::Max(a, b); }
template <int n>
HWY_INLINE I up(I a) {
  return hn::ShiftLeft<n>(a);
}
template <int n>
HWY_INLINE I down(I a) {  // zeros come in
  const hn::Rebind<std::uint32_t, Df> d;
  return hn::BitCast(Di(), hn::ShiftRight<n>(hn::BitCast(d, a)));
}
template <int n>
HWY_INLINE I down_signed(I a) {
  return hn::ShiftRight<n>(a);
}
// Two 16-bit numbers in 32 bits; sums and products modulo 2^16.
HWY_INLINE I add_halves(I a, I b) {
  return hn::BitCast(Di(), hn::Add(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I sub_halves(I a, I b) {
  return hn::BitCast(Di(), hn::Sub(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I max_halves(I a, I b) {
  return hn::BitCast(Di(), hn::Max(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I min_halves(I a, I b) {
  return hn::BitCast(Di(), hn::Min(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I mul_halves(I a, I b) {
  return hn::BitCast(Di(), hn::Mul(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
#if RINGSPLAT_LANES_PAIRS
HWY_INLINE I mul_halves_15(I a, I b) {
  return hn::BitCast(Di(), hn::MulFixedPoint15(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I sum_of_products(I a, I b) {
  I unused = hn::Zero(Di());
  return hn::ReorderWidenMulAccumulate(Di(), hn::BitCast(Dw(), a), hn::BitCast(Dw(), b), hn::Zero(Di()),
                                       unused);
}
#else
HWY_INLINE I low_half(I a) { return down_signed<16>(up<16>(a)); }
HWY_INLINE I high_half(I a) { return down_signed<16>(a); }
HWY_INLINE I scaled(I a, I b) { return down_signed<1>(add(down_signed<14>(mul(a, b)), set_int(1))); }
HWY_INLINE I mul_halves_15(I a, I b) {
  return either(both(scaled(low_half(a), low_half(b)), set_int(0xffff)),
                up<16>(scaled(high_half(a), high_half(b))));
}
HWY_INLINE I sum_of_products(I a, I b) {
  return add(mul(low_half(a), low_half(b)), mul(high_half(a), high_half(b)));
}
#endif
HWY_INLINE M greater(F a, F b) { return hn::Gt(a, b); }
HWY_INLINE M greater(I a, I b) { return hn::RebindMask(Df(), hn::Gt(a, b)); }
HWY_INLINE M equal(F a, F b) { return hn::Eq(a, b); }
HWY_INLINE M both(M a, M b) { return hn::And(a, b); }
HWY_INLINE M either(M a, M b) { return hn::Or(a, b); }
HWY_INLINE M but_not(M a, M b) { return hn::AndNot(b, a); }
HWY_INLINE bool any(M a) { return !hn::AllFalse(Df(), a); }
HWY_INLINE float least(F a) { return hn::GetLane(hn::MinOfLanes(Df(), a)); }
HWY_INLINE float greatest(F a) { return hn::GetLane(hn::MaxOfLanes(Df(), a)); }
HWY_INLINE F choose(M m, F a, F b) { return hn::IfThenElse(m, a, b); }
HWY_INLINE I choose(M m, I a, I b) { return hn::IfThenElse(hn::RebindMask(Di(), m), a, b); }
HWY_INLINE F only(M m, F a) { return hn::IfThenElseZero(m, a); }
HWY_INLINE F gather(const float* base, I at) { return hn::GatherIndex(Df(), base, at); }
/// A tile's pixels from and to rows `pitch` floats apart; channels by lane.
HWY_INLINE void load_rows(const float* pixels, std::ptrdiff_t pitch, float (&rgba)[4][lanes]) {
  const hn::Full128<float> row;
  for (int l = 0; l < lanes; l += tile_width, pixels += pitch) {
    hn::Vec<decltype(row)> r, g, b, a;
    hn::LoadInterleaved4(row, pixels, r, g, b, a);
    hn::Store(r, row, rgba[0] + l);
    hn::Store(g, row, rgba[1] + l);
    hn::Store(b, row, rgba[2] + l);
    hn::Store(a, row, rgba[3] + l);
  }
}
HWY_INLINE void store_rows(const float (&rgba)[4][lanes], float* pixels, std::ptrdiff_t pitch) {
  const hn::Full128<float> row;
  const auto of = [&](int c, int l) HWY_ATTR { return hn::Load(row, rgba[c] + l); };
  for (int l = 0; l < lanes; l += tile_width, pixels += pitch)
    hn::StoreInterleaved4(of(0, l), of(1, l), of(2, l), of(3, l), row, pixels);
}
/// The halves of 64-bit numbers, from places at least 0 in steps of `step` bytes.
struct Halves {
  I low, high;
};
template <int step, class D>
HWY_INLINE hn::Vec<D> load_each(D d, const char* base, const std::int32_t* at) {
  if constexpr (hn::MaxLanes(d) == 1) {
    return hn::LoadU(d,
                     reinterpret_cast<const std::uint64_t*>(base + std::size_t(std::uint32_t(*at)) * step));
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, load_each<step>(half, base, at + hn::MaxLanes(half)),
                       load_each<step>(half, base, at));
  }
}
/// By single loads, which take half as long as gathering does, or less.
template <int step>
HWY_INLINE Halves gather_halves(const void* base, I at) {
  HWY_ALIGN std::int32_t places[lanes];
  hn::Store(at, Di(), places);
  const hn::Repartition<std::uint64_t, Di> d;
  const auto* from = static_cast<const char*>(base);
  const I first = hn::BitCast(Di(), load_each<step>(d, from, places)),
          second = hn::BitCast(Di(), load_each<step>(d, from, places + lanes / 2));
  return {hn::ConcatEven(Di(), second, first), hn::ConcatOdd(Di(), second, first)};
}
HWY_INLINE Halves add_halves(const Halves& a, const Halves& b) {
  return {add_halves(a.low, b.low), add_halves(a.high, b.high)};
}
HWY_INLINE Halves sub_halves(const Halves& a, const Halves& b) {
  return {sub_halves(a.low, b.low), sub_halves(a.high, b.high)};
}
HWY_INLINE Halves mul_halves(const Halves& a, I by) {
  return {mul_halves(a.low, by), mul_halves(a.high, by)};
}
/// Four bytes from each lane's place, in bytes.
HWY_INLINE I gather_int(const void* base, I at) { return gather_halves<1>(base, at).low; }

/// 2^y for y in [-126, 126], to 2e-7.
HWY_INLINE F exp2_of(F y) {
  const I whole = to_int(y);
  const F f = sub(y, to_float(whole));
  F e = set(1.54035304e-4F);
  e = fma(e, f, set(1.33335581e-3F));
  e = fma(e, f, set(9.61812911e-3F));
  e = fma(e, f, set(5.55041087e-2F));
  e = fma(e, f, set(2.40226507e-1F));
  e = fma(e, f, set(6.93147181e-1F));
  e = fma(e, f, set(1.0F));
  return mul(e, from_bits(up<23>(add(whole, set_int(127)))));
}

/// 1 - exp(-x), x at least 0.
HWY_INLINE F opacity_of(F x) {
  const F series = mul(x, fma(x, fma(x, set(1.0F / 6), set(-0.5F)), set(1.0F)));
  const F through = exp2_of(mul(min(x, set(80.0F)), set(-1.44269504F)));
  return choose(greater(set(1.0F / 64), x), series, sub(set(1.0F), through));
}

/// log2 of a normal number above zero, to 2e-7 of 1 + |log2|.
HWY_INLINE F log2_of(F x) {
  const I bits = bits_of(x);
  const F m = from_bits(either(both(bits, set_int(0x7fffff)), set_int(0x3f800000)));
  // atanh's series of s = (m - r) / (m + r) with r = sqrt(2): |s| below 0.1716.
  const F middle = set(1.41421356F);
  const F s = div(sub(m, middle), add(m, middle)), q = mul(s, s);
  F p = set(0.32059889F);  // 2 / (9 ln 2)
  p = fma(p, q, set(0.41219858F));
  p = fma(p, q, set(0.57707802F));
  p = fma(p, q, set(0.96179669F));
  p = fma(p, q, set(2.88539008F));
  const F exponent = to_float(sub(down<23>(bits), set_int(127)));
  return add(fma(p, s, set(0.5F)), exponent);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

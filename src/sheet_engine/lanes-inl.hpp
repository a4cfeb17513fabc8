// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_LANES_INL
#undef RINGSPLAT_LANES_INL
#else
#define RINGSPLAT_LANES_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// Numbers of a few pixels at once: sixteen with AVX-512, eight with AVX2, one elsewhere. All three do the
/// same operations in the same order, so a pixel has the same bits. Elsewhere means also NEON: it has no sums
/// of neighbouring products.
#define RINGSPLAT_LANES_ONE_BY_ONE !(HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2)
#define RINGSPLAT_LANES_PATCHES (HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3)

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if RINGSPLAT_LANES_ONE_BY_ONE

using F = float;
using I = std::int32_t;
using M = bool;
inline constexpr int lanes = 1, tile_width = 1, tile_height = 1;

inline F set(float x) { return x; }
inline I set_int(std::int32_t x) { return x; }
inline F fma(F a, F b, F c) { return std::fma(a, b, c); }
inline F add(F a, F b) { return a + b; }
inline F sub(F a, F b) { return a - b; }
inline F mul(F a, F b) { return a * b; }
inline F div(F a, F b) { return a / b; }
/// The second when one is not a number.
inline F min(F a, F b) { return a < b ? a : b; }
inline F max(F a, F b) { return a > b ? a : b; }
inline F abs(F a) { return std::fabs(a); }
inline F root(F a) { return std::sqrt(a); }
inline F load(const float* p) { return *p; }
inline void store(F a, float* p) { *p = a; }
inline I load(const std::int32_t* p) { return *p; }
inline void store_ints(I a, std::int32_t* p) { *p = a; }
/// To the nearest whole number, ties to even; a must be within the range.
inline I to_int(F a) { return static_cast<I>(std::nearbyint(a)); }
inline F to_float(I a) { return static_cast<F>(a); }
inline I bits_of(F a) { return std::bit_cast<I>(a); }
inline F from_bits(I a) { return std::bit_cast<F>(a); }
inline I wrap(std::int64_t a) { return static_cast<I>(static_cast<std::uint32_t>(a)); }
inline I add(I a, I b) { return wrap(std::int64_t{a} + b); }
inline I sub(I a, I b) { return wrap(std::int64_t{a} - b); }
inline I mul(I a, I b) { return wrap(std::int64_t{a} * b); }
inline I both(I a, I b) { return a & b; }
inline I either(I a, I b) { return a | b; }
inline I min(I a, I b) { return std::min(a, b); }
inline I max(I a, I b) { return std::max(a, b); }
template <int n>
inline I up(I a) {
  return static_cast<I>(static_cast<std::uint32_t>(a) << n);
}
template <int n>
inline I down(I a) {  // zeros come in
  return static_cast<I>(static_cast<std::uint32_t>(a) >> n);
}
template <int n>
inline I down_signed(I a) {
  return a >> n;
}
// Two 16-bit numbers in 32 bits.
inline std::int16_t low_half(I a) { return static_cast<std::int16_t>(a & 0xffff); }
inline std::int16_t high_half(I a) { return static_cast<std::int16_t>(a >> 16); }
inline I pair_of(int low, int high) { return (low & 0xffff) | wrap(std::int64_t{high} * 65536); }
inline I add_halves(I a, I b) { return pair_of(low_half(a) + low_half(b), high_half(a) + high_half(b)); }
inline I sub_halves(I a, I b) { return pair_of(low_half(a) - low_half(b), high_half(a) - high_half(b)); }
// Products modulo 2^16.
inline I mul_halves(I a, I b) { return pair_of(low_half(a) * low_half(b), high_half(a) * high_half(b)); }
inline int scaled(int a, int b) { return (((a * b) >> 14) + 1) >> 1; }
inline I mul_halves_15(I a, I b) {
  return pair_of(scaled(low_half(a), low_half(b)), scaled(high_half(a), high_half(b)));
}
inline I sum_of_products(I a, I b) { return low_half(a) * low_half(b) + high_half(a) * high_half(b); }

inline M greater(F a, F b) { return a > b; }
inline M greater(I a, I b) { return a > b; }
inline M equal(F a, F b) { return a == b; }
inline M both(M a, M b) { return a && b; }
inline M either(M a, M b) { return a || b; }
inline M but_not(M a, M b) { return a && !b; }
inline bool any(M a) { return a; }
inline float least(F a) { return a; }
inline float greatest(F a) { return a; }
inline F choose(M m, F a, F b) { return m ? a : b; }
inline I choose(M m, I a, I b) { return m ? a : b; }
inline F only(M m, F a) { return m ? a : 0.0F; }
/// Four bytes from each lane's place, in bytes.
inline I gather_int(const void* base, I at) {
  I value;
  std::memcpy(&value, static_cast<const char*>(base) + at, sizeof value);
  return value;
}
inline F gather(const float* base, I at) { return base[at]; }
/// A tile's pixels from and to rows `pitch` floats apart; channels by lane.
inline void load_rows(const float* pixels, std::ptrdiff_t, float (&rgba)[4][lanes]) {
  for (int c = 0; c < 4; ++c) rgba[c][0] = pixels[c];
}
inline void store_rows(const float (&rgba)[4][lanes], float* pixels, std::ptrdiff_t) {
  for (int c = 0; c < 4; ++c) pixels[c] = rgba[c][0];
}
/// The halves of 64-bit numbers, from places at least 0 in steps of `step` bytes.
struct Halves {
  I low, high;
};
template <int step>
inline Halves gather_halves(const void* base, I at) {
  return {gather_int(base, at * step), gather_int(base, at * step + 4)};
}

#else

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
HWY_INLINE F fma(F a, F b, F c) { return hn::MulAdd(a, b, c); }
HWY_INLINE F add(F a, F b) { return hn::Add(a, b); }
HWY_INLINE F sub(F a, F b) { return hn::Sub(a, b); }
HWY_INLINE F mul(F a, F b) { return hn::Mul(a, b); }
HWY_INLINE F div(F a, F b) { return hn::Div(a, b); }
HWY_INLINE F min(F a, F b) { return hn::Min(a, b); }
HWY_INLINE F max(F a, F b) { return hn::Max(a, b); }
HWY_INLINE F abs(F a) { return hn::Abs(a); }
HWY_INLINE F root(F a) { return hn::Sqrt(a); }
HWY_INLINE F load(const float* p) { return hn::LoadU(Df(), p); }
HWY_INLINE void store(F a, float* p) { hn::StoreU(a, Df(), p); }
HWY_INLINE I load(const std::int32_t* p) { return hn::LoadU(Di(), p); }
HWY_INLINE void store_ints(I a, std::int32_t* p) { hn::StoreU(a, Di(), p); }
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
HWY_INLINE I down(I a) {
  const hn::Rebind<std::uint32_t, Df> d;
  return hn::BitCast(Di(), hn::ShiftRight<n>(hn::BitCast(d, a)));
}
template <int n>
HWY_INLINE I down_signed(I a) {
  return hn::ShiftRight<n>(a);
}
HWY_INLINE I add_halves(I a, I b) {
  return hn::BitCast(Di(), hn::Add(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I sub_halves(I a, I b) {
  return hn::BitCast(Di(), hn::Sub(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I mul_halves(I a, I b) {
  return hn::BitCast(Di(), hn::Mul(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I mul_halves_15(I a, I b) {
  return hn::BitCast(Di(), hn::MulFixedPoint15(hn::BitCast(Dw(), a), hn::BitCast(Dw(), b)));
}
HWY_INLINE I sum_of_products(I a, I b) {
  I unused = hn::Zero(Di());
  return hn::ReorderWidenMulAccumulate(Di(), hn::BitCast(Dw(), a), hn::BitCast(Dw(), b), hn::Zero(Di()),
                                       unused);
}
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
HWY_INLINE I gather_int(const void* base, I at) { return gather_halves<1>(base, at).low; }

#endif

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

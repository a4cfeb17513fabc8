// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_WARP_WEIGHTS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_WARP_WEIGHTS_INL
#undef RINGSPLAT_WARP_WEIGHTS_INL
#else
#define RINGSPLAT_WARP_WEIGHTS_INL
#endif

#include <cmath>
#include <cstdint>

#include "raster/pixel_vectors-inl.hpp"
#include "raster/warp_row.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// Pixels whose places are found at a time.
inline constexpr int most_places = 64;

/// Finds the weights of the four taps, [tap][pixel]. Compilers make vectors of pixels of the plain loop.
HWY_INLINE void find_weights(const float* HWY_RESTRICT fraction, int count, float (*weights)[most_places]) {
  for (int tap = 0; tap < 4; ++tap) {
    float* HWY_RESTRICT w = weights[tap];
    for (int k = 0; k < count; ++k)
      w[k] =
          std::fma(std::fma(std::fma(cubic[3][tap], fraction[k], cubic[2][tap]), fraction[k], cubic[1][tap]),
                   fraction[k], cubic[0][tap]);
  }
}

/// Finds first taps and weights along one axis, of places start + k · step from k = first on. Places are
/// positive, so that truncation is floor.
HWY_INLINE void find_taps(double start, double step, int first, int count, std::int32_t* HWY_RESTRICT taps,
                          float (*weights)[most_places]) {
  float fraction[most_places];
  for (int k = 0; k < count; ++k) {
    const double place = std::fma(step, double(first + k), start);
    taps[k] = static_cast<std::int32_t>(place);
    fraction[k] = static_cast<float>(place - taps[k]);
  }
  find_weights(fraction, count, weights);
}

#if RINGSPLAT_ONE_BY_ONE

HWY_INLINE void store_clamped(const float* rgba, float* out) {
  const float opacity = std::min(std::max(rgba[3], 0.0F), 1.0F);
  for (int channel = 0; channel < 4; ++channel)
    out[channel] = std::min(std::max(rgba[channel], 0.0F), opacity);
}

#else

/// Clamps what the cubic's negative lobes bring out of range.
template <class D>
HWY_INLINE hn::Vec<D> clamp_pixels(D d, hn::Vec<D> rgba) {
  const auto zero = hn::Zero(d);
  const auto opacity = hn::Min(hn::Max(hn::Broadcast<3>(rgba), zero), hn::Set(d, 1.0F));
  return hn::Min(hn::Max(rgba, zero), opacity);
}

#endif

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_SPLAT_VECTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_SPLAT_VECTORS_INL
#undef RINGSPLAT_SPLAT_VECTORS_INL
#else
#define RINGSPLAT_SPLAT_VECTORS_INL
#endif

#include <cstddef>
#include <cstring>

#include "raster/pixel_vectors-inl.hpp"
#include "splat/splat.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

HWY_INLINE Splat load_splat(const std::byte* bytes) {
  Splat splat;
  std::memcpy(&splat, bytes, sizeof splat);
  return splat;
}

/// Whether a, b, c and the opacity are all numbers that a footprint can give.
HWY_INLINE bool is_plausible(const Splat& splat) {
  const FourFloats d;
  const auto words = hn::LoadU(d, &splat.a);
  return hn::AllTrue(d, hn::Lt(hn::Abs(words), hn::Set(d, largest_coefficient)));
}

/// A splat's, once for each pixel of a vector.
HWY_INLINE Colour load_colour(const Splat& splat) {
  HWY_ALIGN float colour[4];
  hn::Store(premultiply(&splat.red, splat.opacity), FourFloats(), colour);
  return hn::LoadDup128(Floats(), colour);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

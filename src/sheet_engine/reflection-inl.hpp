// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_REFLECTION_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_REFLECTION_INL
#undef RINGSPLAT_REFLECTION_INL
#else
#define RINGSPLAT_REFLECTION_INL
#endif

#include "sheet_engine/lanes-inl.hpp"
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/samplers-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// How a surface is lit: colours times `scale`, plus `highlight`.
struct Reflected {
  F scale, highlight;
};

/// The direction to the viewer, in the coordinates of GradientLight, and its product with the light's.
struct Viewer {
  F u, v, k, light;
};

/// x to the power of a whole number, by squares.
HWY_INLINE F WholePower(F x, int exponent) {
  F power = set(1.0F);
  for (F square = x; exponent > 0; exponent >>= 1, square = mul(square, square))
    if ((exponent & 1) != 0) power = mul(power, square);
  return power;
}

/// x to the power `exponent`, x in [0, 1].
HWY_INLINE F Power(F x, float exponent) {
  if (exponent == 24) {  // the default
    const F x2 = mul(x, x), x4 = mul(x2, x2), x8 = mul(x4, x4);
    return mul(x8, mul(x8, x8));
  }
  constexpr float most = 1024;
  if (exponent <= most && exponent == float(int(exponent))) return WholePower(x, int(exponent));
  const F log = log2_of(max(x, set(1e-30F)));
  return only(greater(x, set(0.0F)), exp2_of(max(mul(log, set(exponent)), set(-126.0F))));
}

/// One over a root, to 4e-6: two of Halley's steps from bits (Blinn 1997). Highway's own differs by
/// processor.
HWY_INLINE F OverRoot(F x) {
  F y = from_bits(sub(set_int(0x5f3759df), down<1>(bits_of(x))));
  const F h = mul(mul(x, y), y);
  return mul(y, fma(h, fma(h, set(0.375F), set(-1.25F)), set(1.875F)));
}

/// Phong's reflection (Phong 1975), two-sided; gradients of any length. Where there is no gradient colours
/// stay as they are.
HWY_INLINE Reflected Reflect(const GradientLight& light, const Viewer& viewer, Gradient g) {
  if (light.oblique) {
    g.u = fma(g.u, set(light.uu), fma(g.v, set(light.uv), mul(g.k, set(light.uk))));
    g.v = fma(g.v, set(light.vv), mul(g.k, set(light.vk)));
  } else {
    g.u = mul(g.u, set(light.uu));
    g.v = mul(g.v, set(light.vv));
  }
  g.k = mul(g.k, set(light.kk));
  const auto along = [&](F u, F v, F k) HWY_ATTR { return fma(g.u, u, fma(g.v, v, mul(g.k, k))); };
  const F zero = set(0.0F);
  const F square = fma(g.u, g.u, fma(g.v, g.v, mul(g.k, g.k))), over = OverRoot(square);
  const F to_light = mul(along(set(light.light[0]), set(light.light[1]), set(light.light[2])), over),
          to_viewer = mul(along(viewer.u, viewer.v, viewer.k), over);
  const M surface = greater(square, zero);
  // Light and viewer on the same side: their product is above zero whichever way the gradient points.
  const F product = mul(to_light, to_viewer);
  const F mirrored = min(max(sub(mul(product, set(2.0F)), viewer.light), zero), set(1.0F));
  const F highlight =
      only(both(surface, greater(product, zero)), mul(Power(mirrored, light.exponent), set(light.specular)));
  return {choose(surface, fma(abs(to_light), set(light.diffuse), set(light.ambient)), set(1.0F)), highlight};
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

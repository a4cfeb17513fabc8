// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_SLAB_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_SLAB_LANES_INL
#undef RINGSPLAT_SLAB_LANES_INL
#else
#define RINGSPLAT_SLAB_LANES_INL
#endif

#include "sheet_engine/lanes-inl.hpp"
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/samplers-inl.hpp"
#include "sheet_engine/slab_table.hpp"

/// Slabs of a table, parts of them, and how they are lit, a lane each.
HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// A table entry in each lane, as it is stored.
using Entry = Halves;
HWY_INLINE Entry Look(const std::uint64_t* table, I front, I back) {
  return gather_halves<sizeof *table>(table, add(up<8>(front), back));
}
HWY_INLINE F OpacityOf(const Entry& e) {
  const F root_of = mul(to_float(both(e.low, set_int(0xffff))), set(1.0F / 65535));
  return mul(root_of, root_of);
}

struct TableSlab {
  F opacity, red, green, blue, centroid, spread;
};
HWY_INLINE TableSlab Unpack(const Entry& e) {
  const I low = e.low, high = e.high;
  const I ten = set_int(1023);
  const F colour = set(1.0F / 1023);
  return {OpacityOf(e),
          mul(colour, to_float(both(down<16>(low), ten))),
          mul(colour, to_float(either(down<26>(low), both(up<6>(high), ten)))),
          mul(colour, to_float(both(down<4>(high), ten))),
          mul(set(1.0F / 255), to_float(both(down<14>(high), set_int(255)))),
          mul(set(1.0F / 127), to_float(both(down<22>(high), set_int(63))))};
}

/// From a voxel's position to where it begins to be the nearest one: positions are rounded down, and of two
/// voxels that are equally near the greater is the nearest.
inline constexpr std::int32_t before_voxel = one_voxel / 2 + 1;
/// The voxels nearest to lanes; beyond the outer ones those. `most`: the last one's position.
HWY_INLINE I NearestVoxel(I position, std::int32_t most) {
  const I within = min(max(position, set_int(0)), set_int(most));
  return down_signed<position_bits>(add(within, set_int(before_voxel)));
}

/// A slab in the colours of its lanes' labels.
HWY_NOINLINE TableSlab Tinted(const SheetPaint& paint, TableSlab slab, const std::uint8_t* labels, I u, I v) {
  const auto nearest = [&](I position, int axis) HWY_ATTR {
    return NearestVoxel(position, (paint.rays.voxels[axis] - 1) << position_bits);
  };
  const I row = mul(nearest(v, 1), set_int(std::int32_t(paint.pitch)));
  const I label = both(gather_int(labels, add(row, nearest(u, 0))), set_int(255));
  if (!any(greater(label, set_int(0)))) return slab;
  const I entry = up<2>(label);
  const F share = gather(paint.tints + 3, entry);
  const auto mix = [&](F& colour, int c)
                       HWY_ATTR { colour = fma(share, sub(gather(paint.tints + c, entry), colour), colour); };
  mix(slab.red, 0);
  mix(slab.green, 1);
  mix(slab.blue, 2);
  return slab;
}

/// What SlabTable::Depth says of a place: the depth as a sum, and how fast it grows with places.
struct Reached {
  F whole, rest, density;
};
HWY_INLINE Reached Reach(const float* depths, F place) {
  constexpr float nodes = SlabTable::nodes_an_entry;
  const F at = mul(place, set(nodes));
  const F node = min(max(to_float(to_int(sub(at, set(0.5F)))), set(0.0F)), set(nodes * TableAxis::last - 1));
  const F t = sub(at, node);
  const I first = up<2>(to_int(node));
  const F slope = gather(depths + 2, first), bend = gather(depths + 3, first), bent = mul(t, bend);
  return {gather(depths, first), fma(t, add(slope, bent), gather(depths + 1, first)),
          mul(set(nodes), add(slope, add(bent, bent)))};
}

/// The opacity between two places, which are those of values that are linear along a slab.
HWY_NOINLINE F OpacityBetween(const SheetPaint& paint, F front, F back) {
  const Reached a = Reach(paint.depths, front), b = Reach(paint.depths, back);
  const F step = sub(back, front), depth = add(sub(b.whole, a.whole), sub(b.rest, a.rest));
  // So near to each other that the depth's rounding would show.
  const M near = greater(set(0.125F), abs(step));
  const F mean =
      choose(near, mul(set(0.5F), add(a.density, b.density)), div(depth, choose(near, set(1.0F), step)));
  return opacity_of(max(mul(mean, set(paint.slab_length)), set(0.0F)));
}

/// 1 - (1 - a)^w, to 1e-6; lanes with w = 1 keep their bits. Any part of what is opaque is.
HWY_INLINE F Shortened(F a, F w) {
  const F one = set(1.0F), through = max(sub(one, a), set(1e-12F));
  const F shorter = max(sub(one, exp2_of(max(mul(w, log2_of(through)), set(-126.0F)))), set(0.0F));
  const M opaque = both(equal(a, one), greater(w, set(0.0F)));
  return choose(either(equal(w, one), opaque), a, shorter);
}

/// The part of the way from sheet to sheet that lies in the volume's box and before clip planes.
struct Way {
  F enter, leave;  ///< 0 and 1 at first

  /// Limits it along one axis, on which it goes from position `a` to `b`.
  HWY_INLINE void narrow(I a, I b, int voxels) {
    const F voxel = set(1.0F / one_voxel), from = mul(voxel, to_float(a)), to = mul(voxel, to_float(b));
    const F low = set(-0.5F), high = set(float(voxels) - 0.5F), step = sub(to, from);
    const M moves = either(greater(step, set(0.0F)), greater(set(0.0F), step));
    const F x = div(sub(low, from), step), y = div(sub(high, from), step);
    const M outside = either(greater(low, from), greater(a, set_int(voxels * one_voxel - one_voxel / 2 - 1)));
    enter = max(enter, choose(moves, min(x, y), choose(outside, set(2.0F), set(0.0F))));
    leave = min(leave, choose(moves, max(x, y), set(1.0F)));
  }
  /// Limits it to where what goes from `a` to `b` is at least 0.
  HWY_INLINE void limit(F a, F b) {
    const F zero = set(0.0F), crossing = div(a, sub(a, b));
    const M from_behind = greater(zero, a), to_behind = greater(zero, b);
    enter = max(enter, only(from_behind, choose(to_behind, set(2.0F), crossing)));
    leave = min(leave, choose(to_behind, only(but_not(to_behind, from_behind), crossing), set(1.0F)));
  }
  HWY_INLINE F length() const { return max(sub(leave, enter), set(0.0F)); }
};

/// How a surface is lit: colours times `scale`, plus `highlight`; and how much of its opacity its steepness
/// leaves.
struct Reflected {
  F scale, highlight, opaque;
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
  F opaque = set(1.0F);
  if (light.edges)
    opaque = min(max(mul(fma(square, over, set(-light.edge_from)), set(light.over_edge)), zero), opaque);
  return {choose(surface, fma(abs(to_light), set(light.diffuse), set(light.ambient)), set(1.0F)), highlight,
          opaque};
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

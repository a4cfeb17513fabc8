#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/draw_with_stencil.cpp"
#include <hwy/foreach_target.h>

#include <type_traits>

#include "splat/painter_kernels.hpp"
#include "splat/splat_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// The stencil's constants of `lanes` pixels.
struct StencilVectors {
  FloatVector k, dx, dy;
  HWY_INLINE void load(const Stencil& stencil, std::size_t vector) {
    const Floats d;
    k = hn::Load(d, stencil.k.get() + vector * lanes);
    dx = hn::Load(d, stencil.dx.get() + vector * lanes);
    dy = hn::Load(d, stencil.dy.get() + vector * lanes);
  }
};

/// One splat's constants in every lane.
struct SplatVectors {
  FloatVector a, b, c, colour;
};

/// Clips a kernel at the region's border and finds out whether it reaches a pixel inside.
class Border {
 public:
  HWY_INLINE Border(const SliceBuffer& slice, int x, int y) {
    const Floats d;
    left_ = hn::Set(d, static_cast<float>(-x));
    right_ = hn::Set(d, static_cast<float>(slice.width - 1 - x));
    top_ = hn::Set(d, static_cast<float>(-y));
    bottom_ = hn::Set(d, static_cast<float>(slice.height - 1 - y));
    largest_ = hn::Zero(d);
  }
  HWY_INLINE FloatVector clip(FloatVector w, const StencilVectors& at) {
    const auto inside = hn::And(hn::And(hn::Ge(at.dx, left_), hn::Le(at.dx, right_)),
                                hn::And(hn::Ge(at.dy, top_), hn::Le(at.dy, bottom_)));
    w = hn::IfThenElseZero(inside, w);
    largest_ = hn::Max(largest_, w);
    return w;
  }
  HWY_INLINE bool reached() const {
    const Floats d;
    return !hn::AllFalse(d, hn::Gt(largest_, hn::Zero(d)));
  }

 private:
  FloatVector left_, right_, top_, bottom_, largest_;
};

/// For kernels whose whole window is in the region. Wherever their ellipse lies, it holds a pixel centre: its
/// semi-axes are a pixel or more (footprint.hpp).
struct NoBorder {
  HWY_INLINE NoBorder(const SliceBuffer&, int, int) {}
  HWY_INLINE FloatVector clip(FloatVector w, const StencilVectors&) { return w; }
  HWY_INLINE bool reached() const { return true; }
};

/// `fixed_vectors`: the stencil's length in vectors if it is short enough to stay in registers, else 0.
template <std::size_t fixed_vectors>
class KernelAdder {
 public:
  HWY_INLINE KernelAdder(const SliceBuffer& slice, const Stencil& stencil)
      : slice_(slice), stencil_(stencil) {
    for (std::size_t v = 0; v < fixed_vectors; ++v) vectors_[v].load(stencil, v);
  }

  /// Returns whether the kernel reaches a pixel centre of the region.
  template <bool at_border>
  HWY_INLINE bool add(const Splat& splat, int x, int y) const {
    const Floats d;
    const SplatVectors constants{hn::Set(d, splat.a), hn::Set(d, splat.b), hn::Set(d, splat.c),
                                 load_colour(splat)};
    float* anchor = slice_.origin + y * slice_.row_floats + x * std::ptrdiff_t{4};
    std::conditional_t<at_border, Border, NoBorder> border(slice_, x, y);
    const std::ptrdiff_t* offset = stencil_.offset.data();
    if constexpr (fixed_vectors > 0) {
      for (std::size_t v = 0; v < fixed_vectors; ++v) {
        add_vector(anchor, offset + v * pixels_a_vector, vectors_[v], constants, border);
      }
    } else {
      const std::size_t vectors = stencil_.blocks / pixels_a_vector;
      StencilVectors at;
      for (std::size_t v = 0; v < vectors; ++v) {
        at.load(stencil_, v);
        add_vector(anchor, offset + v * pixels_a_vector, at, constants, border);
      }
    }
    return border.reached();
  }

 private:
  /// Adds to four vectors of pixels, whose weights are one vector. A pixel block is 4 / pixels_a_vector
  /// vectors.
  template <class Clip>
  HWY_INLINE void add_vector(float* anchor, const std::ptrdiff_t* offset, const StencilVectors& at,
                             const SplatVectors& splat, Clip& border) const {
    const auto q = hn::Add(fused(splat.a, at.dx, at.k), fused(splat.b, at.dy, splat.c));
    const auto w = border.clip(hn::Max(q, hn::Zero(Floats())), at);
    const auto weights = hn::Mul(w, w);
    constexpr std::size_t a_block = 4 / pixels_a_vector;
    add_to(anchor + offset[0], spread_.template get<0>(weights), splat.colour);
    add_to(anchor + offset[1 / a_block] + 1 % a_block * lanes, spread_.template get<1>(weights),
           splat.colour);
    add_to(anchor + offset[2 / a_block] + 2 % a_block * lanes, spread_.template get<2>(weights),
           splat.colour);
    add_to(anchor + offset[3 / a_block] + 3 % a_block * lanes, spread_.template get<3>(weights),
           splat.colour);
  }

  const SliceBuffer& slice_;
  const Stencil& stencil_;
  Spread spread_;
  StencilVectors vectors_[fixed_vectors > 0 ? fixed_vectors : 1];
};

template <std::size_t fixed_vectors>
HWY_INLINE DrawCounts draw_run(const SliceBuffer& slice, const Stencil& stencil, const SplatRun& run,
                               PixelRun* anchors) {
  const KernelAdder<fixed_vectors> kernels(slice, stencil);
  const int left = stencil.reach_x, right = slice.width - 1 - left, top = stencil.reach_y,
            bottom = slice.height - 1 - top;
  DrawCounts counts;
  for (std::size_t i = 0; i < run.count; ++i) {
    const Splat splat = load_splat(run.bytes + i * sizeof(Splat));
    const std::int64_t wide_x = run.base_x + splat.anchor_x, wide_y = run.base_y + splat.anchor_y;
    const bool meets = wide_x >= -left - 1 && wide_x < slice.width + left && wide_y >= -top - 1 &&
                       wide_y < slice.height + top;
    if (!meets || !is_plausible(splat)) continue;
    const int x = static_cast<int>(wide_x), y = static_cast<int>(wide_y);
    anchors[y + top + 1].include(x, x + 1);
    const bool interior = x >= left && x < right && y >= top && y < bottom;
    const bool reached =
        interior ? kernels.template add<false>(splat, x, y) : kernels.template add<true>(splat, x, y);
    if (reached) ++counts.drawn;
  }
  counts.clipped = run.count - counts.drawn;
  return counts;
}

DrawCounts DrawWithStencil(const SliceBuffer& slice, const Stencil& stencil, const SplatRun& run,
                           PixelRun* anchors) {
  if (stencil.blocks == 4) return draw_run<4 / pixels_a_vector>(slice, stencil, run, anchors);
  return draw_run<0>(slice, stencil, run, anchors);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(DrawWithStencil);

DrawCounts draw_with_stencil(const SliceBuffer& slice, const Stencil& stencil, const SplatRun& run,
                             PixelRun* anchors) {
  return HWY_DYNAMIC_DISPATCH(DrawWithStencil)(slice, stencil, run, anchors);
}

}  // namespace ringsplat
#endif

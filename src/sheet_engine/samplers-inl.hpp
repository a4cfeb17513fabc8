// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_SAMPLERS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_SAMPLERS_INL
#undef RINGSPLAT_SAMPLERS_INL
#else
#define RINGSPLAT_SAMPLERS_INL
#endif

#include "sheet_engine/lanes-inl.hpp"

/// Bilinear interpolation of values and of central differences in a slice's plane. A sampler has
///   Plane    what it reads; planes of whole numbers can be added and subtracted,
///   Sheet    where lanes lie in a plane, and their weights,
///   value()    in a plane's numbers,
///   voxel()    the number of the voxel below each lane,
///   cell()     those of the whole cell, as something with corners(), greatest_of() and least_of() two,
///   gradient() up to a factor that is the same for all sheets,
/// and the same between two slices.
HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

struct Gradient {
  F u, v, k;
};
HWY_INLINE Gradient scaled(const Gradient& g, float by) {
  return {mul(g.u, set(by)), mul(g.v, set(by)), mul(g.k, set(by))};
}

/// The numbers of the voxels at a cell's corners in a slice.
struct CellCorners {
  F at, right, below, across;

  HWY_INLINE const CellCorners& corners() const { return *this; }
};

/// Voxel below a tile's lanes, all at once: those of patch-based samplers count from it.
struct Corner {
  int u = 0, v = 0;
};

/// Weights of the four voxels round each lane as pairs of 16 bits, for whole numbers: (1 - fx) fy and fx fy
/// to 14 bits. Sums of products of whole numbers are exact, so however voxels are fetched, bits are the same.
struct PairWeights {
  I upper, lower;
};
HWY_INLINE PairWeights PairWeightsAt(I u, I v) {
  const I fx = both(down<2>(u), set_int(0x3fff)), fy = both(down<1>(v), set_int(0x7fff));
  const I along = add(sub(up<16>(fx), fx), set_int(16384));  // (16384 - fx, fx)
  const I lower = mul_halves_15(along, either(fy, up<16>(fy)));
  return {sub_halves(along, lower), lower};
}
HWY_INLINE F FirstOf(I pairs) { return to_float(down_signed<16>(up<16>(pairs))); }
HWY_INLINE F SecondOf(I pairs) { return to_float(down_signed<16>(pairs)); }
struct PairCell {
  I upper, lower;
  HWY_INLINE CellCorners corners() const {
    return {FirstOf(upper), SecondOf(upper), FirstOf(lower), SecondOf(lower)};
  }
};
HWY_INLINE F greatest_of(const PairCell& a, const PairCell& b) {
  const I most = max_halves(max_halves(a.upper, a.lower), max_halves(b.upper, b.lower));
  return max(FirstOf(most), SecondOf(most));
}
HWY_INLINE F least_of(const PairCell& a, const PairCell& b) {
  const I least = min_halves(min_halves(a.upper, a.lower), min_halves(b.upper, b.lower));
  return min(FirstOf(least), SecondOf(least));
}
HWY_INLINE F greatest_of(const CellCorners& a, const CellCorners& b) {
  return max(max(max(a.at, a.right), max(a.below, a.across)),
             max(max(b.at, b.right), max(b.below, b.across)));
}
HWY_INLINE F least_of(const CellCorners& a, const CellCorners& b) {
  return min(min(min(a.at, a.right), min(a.below, a.across)),
             min(min(b.at, b.right), min(b.below, b.across)));
}

/// What samplers of whole numbers share: a sheet between two slices is a sum of multiples of both, divided.
/// Half-way they are the slices themselves.
template <class Sampler>
struct BetweenSlices {
  template <class P, class S>
  static HWY_INLINE F value_between(const P& front, const P& back, const S& s, int i, int pieces,
                                    std::ptrdiff_t pitch) {
    if (pieces == 2) return mul(Sampler::value(front + back, s, pitch), set(0.5F));
    return mul(Sampler::value(times(front, pieces - i) + times(back, i), s, pitch),
               set(1.0F / float(pieces)));
  }
  template <class P, class S>
  static HWY_INLINE Gradient gradient_between(const P& before, const P& front, const P& back, const P& after,
                                              const S& s, int i, int pieces, std::ptrdiff_t pitch) {
    if (pieces == 2)
      return scaled(Sampler::gradient(front + back, (back - before) + (after - front), s, pitch), 0.5F);
    const int near = pieces - i;
    return scaled(Sampler::gradient(times(front, near) + times(back, i),
                                    times(back - before, near) + times(after - front, i), s, pitch),
                  1.0F / float(pieces));
  }
};

#if RINGSPLAT_LANES_PATCHES

/// 8 x 8 voxels of a plane in two registers, of which lanes pick theirs by permutation.
struct PatchSampler : BetweenSlices<PatchSampler> {
  using Number = std::int16_t;
  static constexpr float unit = pair_unit;
  using Words = hn::Vec<Dw>;
  struct Plane {
    Words upper, lower;  ///< four rows each
    HWY_INLINE Plane operator+(const Plane& o) const {
      return {hn::Add(upper, o.upper), hn::Add(lower, o.lower)};
    }
    HWY_INLINE Plane operator-(const Plane& o) const {
      return {hn::Sub(upper, o.upper), hn::Sub(lower, o.lower)};
    }
  };
  struct Sheet {
    Words at;  ///< pairs of places in the patch
    PairWeights weights;
  };

  static HWY_INLINE Plane plane(const void* origin, std::ptrdiff_t pitch, Corner corner) {
    const auto* p = static_cast<const Number*>(origin) + corner.v * pitch + corner.u;
    return {FourRows(p, pitch), FourRows(p + 4 * pitch, pitch)};
  }
  static HWY_INLINE Sheet sheet(I u, I v, std::ptrdiff_t, Corner corner) {
    const I at = sub(add(up<3>(down_signed<16>(v)), down_signed<16>(u)), set_int(corner.v * 8 + corner.u));
    return {hn::BitCast(Dw(), add(add(up<16>(at), at), set_int(0x10000))), PairWeightsAt(u, v)};
  }
  template <class P>
  static HWY_INLINE F value(const P& p, const Sheet& s, std::ptrdiff_t) {
    return mul(to_float(Sum(p, s)), set(unit));
  }
  static HWY_INLINE F voxel(const Plane& p, const Sheet& s) { return FirstOf(Pairs(p, s, 0, 0)); }
  static HWY_INLINE PairCell cell(const Plane& p, const Sheet& s, std::ptrdiff_t) {
    return {Pairs(p, s, 0, 0), Pairs(p, s, 1, 0)};
  }
  template <class Along>
  static HWY_INLINE Gradient gradient(const Plane& p, const Along& along, const Sheet& s, std::ptrdiff_t) {
    const I u = add(sum_of_products(sub_halves(Pairs(p, s, 0, 1), Pairs(p, s, 0, -1)), s.weights.upper),
                    sum_of_products(sub_halves(Pairs(p, s, 1, 1), Pairs(p, s, 1, -1)), s.weights.lower));
    const I v = add(sum_of_products(sub_halves(Pairs(p, s, 1, 0), Pairs(p, s, -1, 0)), s.weights.upper),
                    sum_of_products(sub_halves(Pairs(p, s, 2, 0), Pairs(p, s, 0, 0)), s.weights.lower));
    return {to_float(u), to_float(v), to_float(Sum(along, s))};
  }

 private:
  static HWY_INLINE Words FourRows(const Number* p, std::ptrdiff_t pitch) {
    const hn::Full128<Number> row;
    const hn::Full256<Number> two;
    const auto pair = [&](const Number* q)
                          HWY_ATTR { return hn::Combine(two, hn::LoadU(row, q + pitch), hn::LoadU(row, q)); };
    return hn::Combine(Dw(), pair(p + 2 * pitch), pair(p));
  }
  static HWY_INLINE I Pairs(const Plane& p, const Sheet& s, int down, int right) {
    const auto at = down == 0 && right == 0
                        ? s.at
                        : hn::Add(s.at, hn::Set(Dw(), static_cast<std::int16_t>(down * 8 + right)));
    return hn::BitCast(Di(), Words{_mm512_permutex2var_epi16(p.upper.raw, at.raw, p.lower.raw)});
  }
  static HWY_INLINE I Sum(const Plane& p, const Sheet& s) {
    return add(sum_of_products(Pairs(p, s, 0, 0), s.weights.upper),
               sum_of_products(Pairs(p, s, 1, 0), s.weights.lower));
  }
};
/// No friend in the class: GCC compiles such without Highway's target, and calls others wrongly from it.
HWY_INLINE PatchSampler::Plane times(const PatchSampler::Plane& p, int n) {
  const auto by = hn::Set(Dw(), static_cast<PatchSampler::Number>(n));
  return {hn::Mul(p.upper, by), hn::Mul(p.lower, by)};
}

#endif

/// Fetches pairs of neighbouring voxels from memory. Planes, their sums and multiples give what a function
/// reads from a plane's numbers.
struct PairSampler : BetweenSlices<PairSampler> {
  using Number = std::int16_t;
  static constexpr float unit = pair_unit;
  struct Plane {
    const Number* origin;
    static constexpr bool is_plane = true;
    HWY_INLINE auto read(const auto& fetch) const { return fetch(origin); }
  };
  template <class A, class B, bool difference>
  struct Two {
    A a;
    B b;
    static constexpr bool is_plane = true;
    HWY_INLINE auto read(const auto& fetch) const {
      if constexpr (difference)
        return sub_halves(a.read(fetch), b.read(fetch));
      else
        return add_halves(a.read(fetch), b.read(fetch));
    }
  };
  template <class P>
  struct Times {
    P plane;
    int by;
    static constexpr bool is_plane = true;
    HWY_INLINE auto read(const auto& fetch) const {
      return mul_halves(plane.read(fetch), set_int(by << 16 | by));
    }
  };
  struct Sheet {
    I at;  ///< bytes from a plane's origin
    PairWeights weights;
  };

  static HWY_INLINE Plane plane(const void* origin, std::ptrdiff_t, Corner) {
    return {static_cast<const Number*>(origin)};
  }
  static HWY_INLINE Sheet sheet(I u, I v, std::ptrdiff_t pitch, Corner) {
    const I at = add(mul(down_signed<16>(v), set_int(static_cast<std::int32_t>(pitch))), down_signed<16>(u));
    return {add(at, at), PairWeightsAt(u, v)};
  }
  template <class P>
  static HWY_INLINE F value(const P& p, const Sheet& s, std::ptrdiff_t pitch) {
    return mul(to_float(Sum(p, s, pitch)), set(unit));
  }
  static HWY_INLINE F voxel(const Plane& p, const Sheet& s) { return FirstOf(Pairs(p, s, 0)); }
  static HWY_INLINE PairCell cell(const Plane& p, const Sheet& s, std::ptrdiff_t pitch) {
    return {Pairs(p, s, 0), Pairs(p, s, pitch)};
  }
  template <class P, class Along>
  static HWY_INLINE Gradient gradient(const P& p, const Along& along, const Sheet& s, std::ptrdiff_t pitch) {
    const auto [left, right] = FourInRow(p, s, 0);
    const auto [left_below, right_below] = FourInRow(p, s, pitch);
    const I u = add(sum_of_products(sub_halves(right, left), s.weights.upper),
                    sum_of_products(sub_halves(right_below, left_below), s.weights.lower));
    const auto middle = [](I before, I after) HWY_ATTR { return either(down<16>(before), up<16>(after)); };
    const I at = middle(left, right), below = middle(left_below, right_below);
    const I v = add(sum_of_products(sub_halves(below, Pairs(p, s, -pitch)), s.weights.upper),
                    sum_of_products(sub_halves(Pairs(p, s, 2 * pitch), at), s.weights.lower));
    return {to_float(u), to_float(v), to_float(Sum(along, s, pitch))};
  }

 private:
  struct FetchPairs {
    I at;
    std::ptrdiff_t numbers;
    HWY_INLINE I operator()(const Number* origin) const { return gather_int(origin + numbers, at); }
  };
  struct FetchFour {
    I at;
    std::ptrdiff_t numbers;
    HWY_INLINE Halves operator()(const Number* origin) const {
      return gather_halves<1>(origin + numbers - 1, at);
    }
  };
  /// The voxel of each lane and its right neighbour.
  template <class P>
  static HWY_INLINE I Pairs(const P& p, const Sheet& s, std::ptrdiff_t numbers) {
    return p.read(FetchPairs{s.at, numbers});
  }
  /// The same and their neighbours, at once: the pairs that begin before the voxel and behind it.
  template <class P>
  static HWY_INLINE Halves FourInRow(const P& p, const Sheet& s, std::ptrdiff_t numbers) {
    return p.read(FetchFour{s.at, numbers});
  }
  template <class P>
  static HWY_INLINE I Sum(const P& p, const Sheet& s, std::ptrdiff_t pitch) {
    return add(sum_of_products(Pairs(p, s, 0), s.weights.upper),
               sum_of_products(Pairs(p, s, pitch), s.weights.lower));
  }
};
template <class A, class B>
requires(A::is_plane&& B::is_plane) HWY_INLINE PairSampler::Two<A, B, false>
operator+(const A& a, const B& b) { return {a, b}; }
template <class A, class B>
requires(A::is_plane&& B::is_plane) HWY_INLINE PairSampler::Two<A, B, true>
operator-(const A& a, const B& b) { return {a, b}; }

template <class P>
requires(P::is_plane) HWY_INLINE PairSampler::Times<P> times(const P& plane, int by) { return {plane, by}; }

/// Fetches floats from memory.
struct FloatSampler {
  using Number = float;
  static constexpr float unit = 1;
  struct Along;
  struct Plane {
    const float* origin;
    HWY_INLINE Along operator-(const Plane& last) const;
  };
  struct Sheet {
    I at;
    F fx, fy;
  };
  /// Two slices, whose difference is the gradient along the slices.
  struct Along {
    Plane next, last;
  };

  static HWY_INLINE Plane plane(const void* origin, std::ptrdiff_t, Corner) {
    return {static_cast<const float*>(origin)};
  }
  static HWY_INLINE Sheet sheet(I u, I v, std::ptrdiff_t pitch, Corner) {
    const F fraction = set(1.0F / 65536);
    return {add(mul(down_signed<16>(v), set_int(static_cast<std::int32_t>(pitch))), down_signed<16>(u)),
            mul(to_float(both(u, set_int(0xffff))), fraction),
            mul(to_float(both(v, set_int(0xffff))), fraction)};
  }
  static HWY_INLINE F value(const Plane& p, const Sheet& s, std::ptrdiff_t pitch) {
    return Mix(s.fy, AlongRow(p, s, 0), AlongRow(p, s, pitch));
  }
  static HWY_INLINE F voxel(const Plane& p, const Sheet& s) { return gather(p.origin, s.at); }
  static HWY_INLINE CellCorners cell(const Plane& p, const Sheet& s, std::ptrdiff_t pitch) {
    return {gather(p.origin, s.at), gather(p.origin + 1, s.at), gather(p.origin + pitch, s.at),
            gather(p.origin + pitch + 1, s.at)};
  }
  static HWY_INLINE Gradient gradient(const Plane& p, const Along& along, const Sheet& s,
                                      std::ptrdiff_t pitch) {
    const auto difference = [&](std::ptrdiff_t plus, std::ptrdiff_t minus)
                                HWY_ATTR { return sub(AlongRow(p, s, plus), AlongRow(p, s, minus)); };
    return {Mix(s.fy, difference(1, -1), difference(pitch + 1, pitch - 1)),
            Mix(s.fy, difference(pitch, -pitch), difference(2 * pitch, 0)),
            sub(value(along.next, s, pitch), value(along.last, s, pitch))};
  }
  static HWY_INLINE F value_between(const Plane& front, const Plane& back, const Sheet& s, int i, int pieces,
                                    std::ptrdiff_t pitch) {
    return Mix(set(float(i) / float(pieces)), value(front, s, pitch), value(back, s, pitch));
  }
  static HWY_INLINE Gradient gradient_between(const Plane& before, const Plane& front, const Plane& back,
                                              const Plane& after, const Sheet& s, int i, int pieces,
                                              std::ptrdiff_t pitch) {
    const F t = set(float(i) / float(pieces));
    const Gradient a = gradient(front, back - before, s, pitch), b = gradient(back, after - front, s, pitch);
    return {Mix(t, a.u, b.u), Mix(t, a.v, b.v), Mix(t, a.k, b.k)};
  }

 private:
  static HWY_INLINE F Mix(F t, F a, F b) { return fma(t, sub(b, a), a); }
  static HWY_INLINE F AlongRow(const Plane& p, const Sheet& s, std::ptrdiff_t numbers) {
    return Mix(s.fx, gather(p.origin + numbers, s.at), gather(p.origin + numbers + 1, s.at));
  }
};

HWY_INLINE FloatSampler::Along FloatSampler::Plane::operator-(const Plane& last) const {
  return {*this, last};
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

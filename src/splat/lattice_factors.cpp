#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/lattice_factors.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/lattice_factors.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using HalfFloats = hn::Rebind<float, Doubles>;
using HalfInts = hn::Rebind<std::int32_t, Doubles>;

/// Positions in a table of `size` steps a period: the step, and the rest in [0, 1].
struct Steps {
  hn::Vec<HalfInts> index;
  hn::Vec<HalfFloats> rest;
};
HWY_INLINE Steps steps_of(hn::Vec<Doubles> position, int size) {
  const Doubles d;
  const auto at = hn::Mul(hn::Sub(position, hn::Floor(position)), hn::Set(d, static_cast<double>(size)));
  const auto step = hn::Min(hn::Floor(at), hn::Set(d, size - 1.0));
  return {hn::DemoteTo(HalfInts(), step), hn::DemoteTo(HalfFloats(), hn::Sub(at, step))};
}

void LatticeFactors(const LatticeRow& row, std::int64_t x, std::size_t count, float* factors) {
  const Doubles d;
  const HalfFloats half;
  const HalfInts ints;
  const auto between = [](auto low, auto high, auto rest) {
    return hn::Add(low, hn::Mul(rest, hn::Sub(high, low)));
  };
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto column = hn::Iota(d, static_cast<double>(x + static_cast<std::int64_t>(i)));
    const auto right = hn::Sub(hn::Add(column, hn::Set(d, 0.5)), hn::Set(d, row.voxel_x));
    const Steps u =
        steps_of(hn::Add(hn::Mul(hn::Set(d, row.u_step), right), hn::Set(d, row.u_start)), row.width);
    const Steps v =
        steps_of(hn::Add(hn::Mul(hn::Set(d, row.v_step), right), hn::Set(d, row.v_start)), row.height);
    const auto at = hn::Add(hn::Mul(v.index, hn::Set(ints, row.width + 1)), u.index);
    const float* below = row.table + row.width + 1;
    const auto first =
        between(hn::GatherIndex(half, row.table, at), hn::GatherIndex(half, row.table + 1, at), u.rest);
    const auto second =
        between(hn::GatherIndex(half, below, at), hn::GatherIndex(half, below + 1, at), u.rest);
    hn::StoreU(between(first, second, v.rest), half, factors + i);
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(LatticeFactors);

void lattice_factors(const LatticeRow& row, std::int64_t x, std::size_t count, float* factors) {
  HWY_DYNAMIC_DISPATCH(LatticeFactors)(row, x, count, factors);
}

}  // namespace ringsplat
#endif

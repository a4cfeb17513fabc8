#include "splat/place_run.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/place_run.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using HalfFloats = hn::Rebind<float, Doubles>;
using HalfInts = hn::Rebind<std::int32_t, Doubles>;

/// Voxels' positions along one axis of the image plane: the anchor's pixel minus the base, and the offset
/// from it.
struct Offsets {
  hn::Vec<Doubles> anchor, offset;
};

HWY_INLINE Offsets offsets(const double* steps, double start, double base) {
  const Doubles d;
  const auto shifted = hn::Sub(hn::Add(hn::Set(d, start), hn::LoadU(d, steps)), hn::Set(d, 0.5));
  const auto pixel = hn::Floor(shifted);
  return {hn::Sub(pixel, hn::Set(d, base)), hn::Sub(shifted, pixel)};
}

void PlaceRun(const Footprint& footprint, const SliceDda& dda, std::uint32_t first, int count,
              std::int64_t base_x, std::int64_t base_y, RunPlaces& places) {
  const Doubles d;
  const HalfFloats f;
  const HalfInts i;
  const auto a_x = hn::Set(d, -2 * footprint.d), e = hn::Set(d, footprint.e),
             minus_e = hn::Set(d, -footprint.e), b_y = hn::Set(d, 2 * footprint.f), half = hn::Set(d, 0.5),
             one = hn::Set(d, 1.0);
  // The last vector may read beyond the row's voxels and write beyond the last place; both have room.
  for (int k = 0; k < count; k += int(hn::Lanes(d))) {
    const Offsets x = offsets(dda.steps_x() + first + k, dda.row_start().x, static_cast<double>(base_x));
    const Offsets y = offsets(dda.steps_y() + first + k, dda.row_start().y, static_cast<double>(base_y));
    const auto a = hn::Sub(hn::Mul(a_x, x.offset), hn::Mul(e, y.offset));
    const auto b = hn::Sub(hn::Mul(minus_e, x.offset), hn::Mul(b_y, y.offset));
    const auto c = hn::Sub(one, hn::Mul(half, hn::Add(hn::Mul(a, x.offset), hn::Mul(b, y.offset))));
    hn::StoreU(hn::DemoteTo(f, a), f, places.a.data() + k);
    hn::StoreU(hn::DemoteTo(f, b), f, places.b.data() + k);
    hn::StoreU(hn::DemoteTo(f, c), f, places.c.data() + k);
    hn::StoreU(hn::DemoteTo(i, x.anchor), i, places.anchor_x.data() + k);
    hn::StoreU(hn::DemoteTo(i, y.anchor), i, places.anchor_y.data() + k);
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(PlaceRun);

void place_run(const Footprint& footprint, const SliceDda& dda, std::uint32_t first, int count,
               std::int64_t base_x, std::int64_t base_y, RunPlaces& places) {
  HWY_DYNAMIC_DISPATCH(PlaceRun)(footprint, dda, first, count, base_x, base_y, places);
}

}  // namespace ringsplat
#endif

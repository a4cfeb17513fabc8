#include "ringsplat/base/vector_config.hpp"
#include "ringsplat/classify/phong.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "classify/shade_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void ShadeRow(const PhongTable& table, const NormalCode* normals, VisibleRow& row) {
#if RINGSPLAT_ONE_BY_ONE
  for (std::uint32_t k = 0; k < row.visible; ++k)
    row.samples[k] = table.shade(normals[row.columns[k]], row.samples[k]);
#else
  const hn::Full128<float> d;
  const hn::Full64<float> pair;
  const auto one = hn::Set(d, 1.0F);
  const auto colours = hn::FirstN(d, 3);
  const std::uint32_t* columns = row.columns.data();
  ClassifiedSample* samples = row.samples.data();
  for (std::uint32_t k = 0; k < row.visible; ++k) {
    const auto entry = hn::ZeroExtendVector(d, hn::LoadU(pair, &table.entry_of(normals[columns[k]]).scale));
    const auto sample = hn::LoadU(d, &samples[k].r);
    const auto shaded =
        hn::Min(hn::Add(hn::Mul(sample, hn::Broadcast<0>(entry)), hn::Broadcast<1>(entry)), one);
    hn::StoreU(hn::IfThenElse(colours, shaded, sample), d, &samples[k].r);
  }
#endif
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(ShadeRow);

void PhongTable::shade(const NormalCode* normals, VisibleRow& row) const {
  HWY_DYNAMIC_DISPATCH(ShadeRow)(*this, normals, row);
}

}  // namespace ringsplat
#endif

#include "ringsplat/base/vector_config.hpp"
#include "ringsplat/classify/phong.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "classify/shade_samples.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void ShadeSamples(const PhongTable& table, const NormalCode* normals, const ClassifiedSample* samples,
                  std::size_t count, ClassifiedSample* lit) {
#if RINGSPLAT_ONE_BY_ONE
  for (std::size_t k = 0; k < count; ++k) lit[k] = table.shade(normals[k], samples[k]);
#else
  const hn::Full128<float> d;
  const hn::Full64<float> pair;
  const auto one = hn::Set(d, 1.0F);
  const auto colours = hn::FirstN(d, 3);
  for (std::size_t k = 0; k < count; ++k) {
    const PhongTable::Entry& of_normal = table.entry(normals[k]);
    const auto entry = hn::ZeroExtendVector(d, hn::LoadU(pair, &of_normal.scale));
    const auto sample = hn::LoadU(d, &samples[k].r);
    const auto shaded =
        hn::Min(hn::Add(hn::Mul(sample, hn::Broadcast<0>(entry)), hn::Broadcast<1>(entry)), one);
    hn::StoreU(hn::IfThenElse(colours, shaded, sample), d, &lit[k].r);
  }
#endif
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(ShadeSamples);

void PhongTable::shade(const NormalCode* normals, const ClassifiedSample* samples, std::size_t count,
                       ClassifiedSample* lit) const {
  HWY_DYNAMIC_DISPATCH(ShadeSamples)(*this, normals, samples, count, lit);
}

}  // namespace ringsplat
#endif

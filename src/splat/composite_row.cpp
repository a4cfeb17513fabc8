#include "splat/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/composite_row.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>

#include "splat/painter_kernels.hpp"
#include "splat/pixel_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

#if RINGSPLAT_ONE_BY_ONE

void CompositeRow(float* HWY_RESTRICT slice, float* HWY_RESTRICT image, std::size_t floats, float opaque) {
  for (std::size_t i = 0; i < floats; i += 4) {
    float* pixel = slice + i;
    float* behind = image + i;
    const float opacity = std::min(std::max(pixel[3], 0.0F), 1.0F), left = 1.0F - behind[3];
    const float transmittance = left < opaque ? 0.0F : left;
    for (int k = 0; k < 4; ++k) {
      behind[k] = std::fma(transmittance, std::min(std::max(pixel[k], 0.0F), opacity), behind[k]);
    }
    std::fill_n(pixel, 4, 0.0F);
  }
}

#else

void CompositeRow(float* HWY_RESTRICT slice, float* HWY_RESTRICT image, std::size_t floats, float opaque) {
  const Floats d;
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0F), least = hn::Set(d, opaque);
  for (std::size_t i = 0; i < floats; i += lanes) {
    const auto pixel = hn::Load(d, slice + i);
    hn::Store(zero, d, slice + i);
    const auto opacity = hn::Min(hn::Max(hn::Broadcast<3>(pixel), zero), one);
    const auto added = hn::Min(hn::Max(pixel, zero), opacity);
    const auto behind = hn::Load(d, image + i);
    const auto left = hn::Sub(one, hn::Broadcast<3>(behind));
    const auto transmittance = hn::IfThenZeroElse(hn::Lt(left, least), left);
    hn::Store(hn::MulAdd(transmittance, added, behind), d, image + i);
  }
}

#endif

std::int64_t ThisTarget() { return HWY_TARGET; }

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(CompositeRow);
HWY_EXPORT(ThisTarget);

void composite_row(float* slice, float* image, std::size_t floats, float opaque) {
  HWY_DYNAMIC_DISPATCH(CompositeRow)(slice, image, floats, opaque);
}

const char* vector_target() { return hwy::TargetName(HWY_DYNAMIC_DISPATCH(ThisTarget)()); }

std::vector<std::string> vector_targets() {
  std::vector<std::string> names;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets())
    names.emplace_back(hwy::TargetName(target));
  return names;
}

void use_vector_target(const std::string& name) {
  hwy::SetSupportedTargetsForTest(0);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if (name == hwy::TargetName(target)) hwy::SetSupportedTargetsForTest(target);
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace ringsplat
#endif

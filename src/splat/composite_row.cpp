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
    composite_pixel(slice + i, opaque, image + i);
    std::fill_n(slice + i, 4, 0.0F);
  }
}

#else

void CompositeRow(float* HWY_RESTRICT slice, float* HWY_RESTRICT image, std::size_t floats, float opaque) {
  const Floats d;
  for (std::size_t i = 0; i < floats; i += lanes) {
    composite_pixels(hn::Load(d, slice + i), hn::Set(d, opaque), image + i);
    hn::Store(hn::Zero(d), d, slice + i);
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

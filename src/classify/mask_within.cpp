#include "classify/mask_within.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "classify/mask_within.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "classify/mask_where.hpp"

#ifndef RINGSPLAT_MASK_WITHIN_ONCE
#define RINGSPLAT_MASK_WITHIN_ONCE
namespace ringsplat {
namespace {

template <class Bits>
std::uint64_t one_by_one(const std::byte* row, int first, int count, Bits low, Bits span) {
  return mask_where<Bits>(row, first, count,
                          [low, span](Bits bits) { return std::uint8_t(Bits(bits - low) <= span); });
}

}  // namespace
}  // namespace ringsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The mask of mask_bits scalars.
template <class Bits>
std::uint64_t within(const std::byte* values, Bits low, Bits span) {
#if RINGSPLAT_ONE_BY_ONE
  return one_by_one(values, 0, mask_bits, low, span);
#else
  const hn::CappedTag<Bits, mask_bits> d;
  constexpr std::size_t spare = 8;  // bytes that storing a mask may overwrite
  std::uint8_t bytes[mask_bits / 8 + spare];
  for (std::size_t at = 0; at < mask_bits; at += hn::Lanes(d)) {
    const auto bits = hn::LoadU(d, reinterpret_cast<const Bits*>(values) + at);
    const auto above = hn::Sub(bits, hn::Set(d, low));
    hn::StoreMaskBits(d, hn::Eq(hn::Min(above, hn::Set(d, span)), above), bytes + at / 8);
  }
  std::uint64_t mask = 0;
  for (std::size_t k = 0; k < mask_bits / 8; ++k) mask |= std::uint64_t{bytes[k]} << 8 * k;
  return mask;
#endif
}

std::uint64_t Within8(const std::byte* values, std::uint8_t low, std::uint8_t span) {
  return within(values, low, span);
}
std::uint64_t Within16(const std::byte* values, std::uint16_t low, std::uint16_t span) {
  return within(values, low, span);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(Within8);
HWY_EXPORT(Within16);

std::uint64_t mask_within(const std::byte* row, int first, int count, std::uint8_t low, std::uint8_t span) {
  if (count < mask_bits) return one_by_one(row, first, count, low, span);
  return HWY_DYNAMIC_DISPATCH(Within8)(row + first, low, span);
}
std::uint64_t mask_within(const std::byte* row, int first, int count, std::uint16_t low, std::uint16_t span) {
  if (count < mask_bits) return one_by_one(row, first, count, low, span);
  return HWY_DYNAMIC_DISPATCH(Within16)(row + sizeof low * std::size_t(first), low, span);
}

}  // namespace ringsplat
#endif

#include "ringsplat/classify/sample_row.hpp"

#include "ringsplat/base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "classify/sample_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "classify/mask_where.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if RINGSPLAT_ONE_BY_ONE

using Colour = ClassifiedSample;
HWY_INLINE Colour read(const ClassifiedSample& sample) { return sample; }
HWY_INLINE void write(const Colour& colour, ClassifiedSample& sample) { sample = colour; }
HWY_INLINE Colour light(const Colour& colour, const PhongTable& phong, NormalCode normal) {
  return phong.shade(normal, colour);
}

#else

using FourFloats = hn::Full128<float>;
using Colour = hn::Vec<FourFloats>;
HWY_INLINE Colour read(const ClassifiedSample& sample) { return hn::LoadU(FourFloats(), &sample.r); }
HWY_INLINE void write(Colour colour, ClassifiedSample& sample) {
  hn::StoreU(colour, FourFloats(), &sample.r);
}
HWY_INLINE Colour light(Colour colour, const PhongTable& phong, NormalCode normal) {
  const FourFloats d;
  const hn::Full64<float> pair;
  const auto entry = hn::ZeroExtendVector(d, hn::LoadU(pair, &phong.entry_of(normal).scale));
  const auto lit =
      hn::Min(hn::Add(hn::Mul(colour, hn::Broadcast<0>(entry)), hn::Broadcast<1>(entry)), hn::Set(d, 1.0F));
  return hn::IfThenElse(hn::FirstN(d, 3), lit, colour);
}

#endif

/// colour(column, k): of the row's k-th visible voxel.
template <class ColourOf>
HWY_INLINE void fill(VisibleRow& out, const ColourOf& colour) {
  ClassifiedSample* const samples = out.samples.data();
  std::uint32_t k = 0;
  for (const VisibleBlock& block : out.blocks)
    for (std::uint64_t mask = block.mask; mask != 0; mask &= mask - 1, ++k)
      write(colour(block.first + std::uint32_t(std::countr_zero(mask)), k), samples[k]);
}

template <class T>
HWY_INLINE void fill_from_table(const Classifier::Table& table, const std::byte* row, const PhongTable* phong,
                                const NormalCode* normals, VisibleRow& out) {
  const auto unlit = [&](std::uint32_t column) {
    const int value = load<T>(row, int(column));
    return read(table.samples[std::clamp(value, table.low, table.high) - table.low]);
  };
  if (phong == nullptr)
    fill(out, [&](std::uint32_t column, std::uint32_t) { return unlit(column); });
  else
    fill(out,
         [&](std::uint32_t column, std::uint32_t) { return light(unlit(column), *phong, normals[column]); });
}

void FillFromTable(const Classifier::Table& table, ScalarType type, const std::byte* row,
                   const PhongTable* phong, const NormalCode* normals, VisibleRow& out) {
  switch (type) {
    case ScalarType::uint8:
      return fill_from_table<std::uint8_t>(table, row, phong, normals, out);
    case ScalarType::int8:
      return fill_from_table<std::int8_t>(table, row, phong, normals, out);
    case ScalarType::uint16:
      return fill_from_table<std::uint16_t>(table, row, phong, normals, out);
    default:
      return fill_from_table<std::int16_t>(table, row, phong, normals, out);
  }
}

void LightRow(const PhongTable& phong, const NormalCode* normals, VisibleRow& out) {
  const ClassifiedSample* const samples = out.samples.data();
  fill(out, [&](std::uint32_t column, std::uint32_t k) {
    return light(read(samples[k]), phong, normals[column]);
  });
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(FillFromTable);
HWY_EXPORT(LightRow);

void make_samples(const Classifier& classifier, const std::byte* row, const PhongTable* phong,
                  const NormalCode* normals, VisibleRow& out) {
  if (normals == nullptr) phong = nullptr;
  if (const auto table = classifier.table()) {
    if (out.samples.size() < out.visible) out.samples.resize(out.visible);
    HWY_DYNAMIC_DISPATCH(FillFromTable)(*table, classifier.type(), row, phong, normals, out);
  } else if (phong != nullptr) {
    HWY_DYNAMIC_DISPATCH(LightRow)(*phong, normals, out);
  }
}

}  // namespace ringsplat
#endif

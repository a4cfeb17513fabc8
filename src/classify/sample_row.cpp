#include "classify/phong.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "classify/sample_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <bit>
#include <cstring>
#include <type_traits>

#include "volume/scalars.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FourFloats = hn::Full128<float>;
using Colour = hn::Vec<FourFloats>;
HWY_INLINE Colour read(const ClassifiedSample& sample) { return hn::LoadU(FourFloats(), &sample.r); }
HWY_INLINE void write(Colour colour, ClassifiedSample& sample) {
  hn::StoreU(colour, FourFloats(), &sample.r);
}
HWY_INLINE Colour light(Colour colour, const PhongTable::Entries& lights, std::size_t place) {
  const FourFloats d;
  const auto scale = hn::Abs(hn::Set(d, lights.scales[place])),
             add = hn::Set(d, lights.highlights[lights.highlight_of(place)]);
  const auto lit = hn::Min(hn::Add(hn::Mul(colour, scale), add), hn::Set(d, 1.0F));
  return hn::IfThenElse(hn::FirstN(d, 3), lit, colour);
}

/// One for each column of a block.
template <class T>
using Block = T[mask_bits];

/// A block's part of a row, of which `left` columns are left: the row's own, or a copy with zeros behind.
template <class T>
HWY_INLINE const T* whole_block(const void* row, int left, Block<T>& copy) {
  if (left >= mask_bits) return static_cast<const T*>(row);
  std::memset(copy, 0, sizeof copy);
  std::memcpy(copy, row, sizeof(T) * std::size_t(left));
  return copy;
}

/// The columns' places in a table, made together. Differences fit the type, but the compiler cannot know
/// that.
template <class T>
HWY_INLINE void places_of_values(const Classifier::Table& table, const std::byte* row, int left,
                                 Block<std::make_unsigned_t<T>>& places) {
  const hn::CappedTag<T, mask_bits> d;
  const auto low = hn::Set(d, T(table.low)), high = hn::Set(d, T(table.high));
  Block<T> copy;
  const T* const values = whole_block<T>(row, left, copy);
  for (std::size_t i = 0; i < mask_bits; i += hn::Lanes(d)) {
    const auto value = hn::LoadU(d, values + i);
    hn::StoreU(hn::Sub(hn::Min(hn::Max(value, low), high), low), d, reinterpret_cast<T*>(places) + i);
  }
}

HWY_INLINE void places_of_normals(const NormalCode* row, int left, Block<std::uint16_t>& places) {
  const hn::CappedTag<std::uint16_t, mask_bits> d;
  Block<NormalCode> copy;
  row = whole_block<NormalCode>(row, left, copy);
  for (std::size_t i = 0; i < mask_bits; i += hn::Lanes(d)) {
    const auto code = hn::LoadU(d, row + i);
    const auto opposite = hn::SaturatedSub(hn::Set(d, std::uint16_t(opposite_codes)), code);
    hn::StoreU(hn::Min(code, opposite), d, places + i);
  }
}

/// colour(i, k) is the colour of the block's column i, the row's k-th voxel.
template <class ColourOf>
HWY_INLINE void fill_block(const VisibleBlock& block, ClassifiedSample* samples, const ColourOf& colour) {
  samples += block.sample;
  std::uint32_t k = 0;
  for (std::uint64_t mask = block.mask; mask != 0; mask &= mask - 1, ++k)
    write(colour(std::countr_zero(mask), k), samples[k]);
}

template <class T>
HWY_INLINE void fill_from_table(const Classifier::Table& table, const VoxelRow& row, const PhongTable* phong,
                                VisibleRow& out) {
  Block<std::make_unsigned_t<T>> values;
  Block<std::uint16_t> entries;
  ClassifiedSample* const samples = out.samples.data();
  for (const VisibleBlock& block : out.blocks) {
    const int left = row.columns - int(block.first);
    places_of_values<T>(table, row.values + sizeof(T) * block.first, left, values);
    if (phong != nullptr) places_of_normals(row.normals + block.first, left, entries);
    const auto unlit = [&](int i) { return read(table.samples[values[i]]); };
    if (phong == nullptr)
      fill_block(block, samples, [&](int i, std::uint32_t) { return unlit(i); });
    else
      fill_block(block, samples, [&, lights = phong->entries()](int i, std::uint32_t) {
        return light(unlit(i), lights, entries[i]);
      });
  }
}

void FillFromTable(const Classifier::Table& table, ScalarType type, const VoxelRow& row,
                   const PhongTable* phong, VisibleRow& out) {
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (sizeof(T) <= 2) fill_from_table<T>(table, row, phong, out);
  });
}

void LightRow(const PhongTable& phong, const VoxelRow& row, VisibleRow& out) {
  Block<std::uint16_t> entries;
  ClassifiedSample* const samples = out.samples.data();
  for (const VisibleBlock& block : out.blocks) {
    places_of_normals(row.normals + block.first, row.columns - int(block.first), entries);
    fill_block(block, samples, [&, lights = phong.entries()](int i, std::uint32_t k) {
      return light(read(samples[block.sample + k]), lights, entries[i]);
    });
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(FillFromTable);
HWY_EXPORT(LightRow);

namespace {

void evaluate_row(const Classifier& classifier, const VoxelRow& row, VisibleRow& out) {
  visit_type(classifier.type(), [&](auto zero) {
    auto sample = out.samples.begin();
    for (const VisibleBlock& block : out.blocks)
      for (std::uint64_t mask = block.mask; mask != 0; mask &= mask - 1)
        *sample++ = classifier.evaluate(
            double(load<decltype(zero)>(row.values, block.first + std::size_t(std::countr_zero(mask)))));
  });
}

}  // namespace

void make_samples(const Classifier& classifier, const VoxelRow& row, const PhongTable* phong,
                  VisibleRow& out) {
  if (row.normals == nullptr) phong = nullptr;
  if (out.samples.size() < out.visible) out.samples.resize(out.visible);
  if (const auto table = classifier.table()) {
    HWY_DYNAMIC_DISPATCH(FillFromTable)(*table, classifier.type(), row, phong, out);
    return;
  }
  evaluate_row(classifier, row, out);
  if (phong != nullptr) HWY_DYNAMIC_DISPATCH(LightRow)(*phong, row, out);
}

}  // namespace ringsplat
#endif

#include "classify/classifier.hpp"

#include <bit>
#include <cmath>

#include "base/srgb.hpp"
#include "classify/adjust.hpp"
#include "classify/piecewise.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

/// 1 − (1 − α)^length, by logarithms, so that an opacity of 1e-7 keeps all its digits.
double corrected(double opacity, double length) {
  if (opacity >= 1.0 || opacity <= 0.0 || length == 1.0) return opacity;
  return -std::expm1(length * std::log1p(-opacity));
}

/// Clamps a whole number to the range of an integer type.
template <class T>
int bounded(double whole) {
  using Limits = std::numeric_limits<T>;
  return int(std::clamp(whole, double(Limits::min()), double(Limits::max())));
}

}  // namespace

Classifier::Classifier(const TransferFunction& tf, ScalarType type, double length)
    : tf_(tf), type_(type), length_(length) {
  for (const auto& point : tf_.colours) linear_.push_back(srgb_to_linear(point.srgb));
  const auto& points = tf_.opacities;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(points[i].opacity > 0)) continue;
    support_low_ = std::min(support_low_, i == 0 ? -infinity : points[i - 1].value);
    support_high_ = std::max(support_high_, i + 1 == points.size() ? infinity : points[i + 1].value);
  }
  visit_type(type_, [this](auto zero) {
    using T = decltype(zero);
    if constexpr (sizeof(T) <= 2) make_table<T>();
  });
}

template <class T>
void Classifier::make_table() {
  // All values before the first points have one sample, and so do all from the last points on.
  const DataRange ends = ends_of(tf_);
  table_low_ = bounded<T>(std::floor(ends.low) - 1);
  table_high_ = bounded<T>(std::ceil(ends.high));
  for (int value = table_low_; value <= table_high_; ++value) table_.push_back(evaluate(value));
}

ClassifiedSample Classifier::evaluate(double value) const {
  if (!(value >= support_low_ && value <= support_high_)) return {};  // NaN too
  const double opacity = opacity_at(tf_.opacities, value);
  if (!(opacity > 0)) return {};
  const Place c = locate(tf_.colours, value);
  glm::dvec3 colour = linear_[c.index];
  if (c.t > 0) colour = blend(colour, linear_[c.index + 1], c.t);
  return {float(colour.x), float(colour.y), float(colour.z), float(corrected(opacity, length_))};
}

void Classifier::find_row(const std::byte* row, int first, int end, std::uint64_t* masks) const {
  visit_type(type_, [&](auto zero) {
    using T = decltype(zero);
    const auto is_visible = [&](int column) {
      const T value = load<T>(row, std::size_t(column));
      if constexpr (sizeof(T) <= 2)
        return table_[table_index(value)].opacity > 0;
      else
        return evaluate(double(value)).opacity > 0;
    };
    for (int column = first; column < end;) {
      const int block = column / mask_bits, next = std::min((block + 1) * mask_bits, end);
      std::uint64_t mask = 0;
      for (; column < next; ++column) mask |= std::uint64_t{is_visible(column)} << column % mask_bits;
      masks[block] |= mask;
    }
  });
}

void VisibleRow::take(std::span<const std::uint64_t> masks, std::uint32_t first, std::uint32_t end) {
  constexpr std::uint64_t all = ~std::uint64_t{0};
  blocks.clear();
  visible = 0;
  if (first >= end) return;
  const std::uint32_t first_block = first / mask_bits, last_block = (end - 1) / mask_bits;
  for (std::uint32_t block = first_block; block <= last_block; ++block) {
    std::uint64_t mask = masks[block];
    if (block == first_block) mask &= all << first % mask_bits;
    if (block == last_block) mask &= all >> (mask_bits - 1 - (end - 1) % mask_bits);
    if (mask == 0) continue;
    blocks.push_back({block * mask_bits, visible, mask});
    visible += std::uint32_t(std::popcount(mask));
  }
}

}  // namespace ringsplat

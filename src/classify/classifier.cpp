#include "ringsplat/classify/classifier.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "classify/piecewise.hpp"
#include "classify/srgb.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// 1 − (1 − α)^length. By way of logarithms, so that an opacity of 1e-7 keeps all its digits.
double corrected(double opacity, double length) {
  if (opacity >= 1.0 || opacity <= 0.0 || length == 1.0) return opacity;
  return -std::expm1(length * std::log1p(-opacity));
}

/// The smallest interval outside of which everything is transparent; empty (low > high) when all is.
struct Support {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
};

Support support_of(const std::vector<TransferFunction::OpacityPoint>& points) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Support support;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(points[i].opacity > 0)) continue;
    support.low = std::min(support.low, i == 0 ? -infinity : points[i - 1].value);
    support.high = std::max(support.high, i + 1 == points.size() ? infinity : points[i + 1].value);
  }
  return support;
}

template <class T>
T load(const std::byte* row, int i) {
  T value;
  std::memcpy(&value, row + sizeof(T) * std::size_t(i), sizeof(T));
  return value;
}

/// Writes each position and moves on only behind those that are visible: no branch to mispredict.
template <class T, class Visible>
int select(const std::byte* row, int count, std::uint32_t* where, const Visible& visible) {
  int selected = 0;
  for (int i = 0; i < count; ++i) {
    where[selected] = std::uint32_t(i);
    selected += visible(load<T>(row, i));
  }
  return selected;
}

template <class Bits>
int classify_by_table(const std::byte* row, int count, const std::vector<ClassifiedSample>& table,
                      const std::vector<std::uint8_t>& visible, std::uint32_t* where,
                      ClassifiedSample* samples) {
  const std::uint8_t* flags = visible.data();
  const int selected = select<Bits>(row, count, where, [flags](Bits bits) { return flags[bits]; });
  for (int k = 0; k < selected; ++k) samples[k] = table[load<Bits>(row, int(where[k]))];
  return selected;
}

}  // namespace

Classifier::Classifier(const TransferFunction& tf, ScalarType type, double length)
    : tf_(tf), type_(type), length_(length) {
  check(tf_, tf_.name);
  if (!(length > 0))
    throw InputError(fmt::format("a distance of {} between slices is not positive", length),
                     "check the volume's spacing and the view");
  for (const auto& point : tf_.colours) linear_.push_back(srgb_to_linear(point.srgb));
  const Support support = support_of(tf_.opacities);
  support_low_ = support.low;
  support_high_ = support.high;
  visit_type(type_, [this](auto zero) {
    using T = decltype(zero);
    if constexpr (sizeof(T) <= 2) {
      table_.resize(std::size_t(1) << (8 * sizeof(T)));
      visible_.resize(table_.size());
      for (std::size_t bits = 0; bits < table_.size(); ++bits) {
        table_[bits] = evaluate(static_cast<T>(static_cast<std::make_unsigned_t<T>>(bits)));
        visible_[bits] = table_[bits].opacity > 0;
      }
    }
  });
}

ClassifiedSample Classifier::evaluate(double value) const {
  if (!(value >= support_low_ && value <= support_high_)) return {};  // NaN too
  const Place o = locate(tf_.opacities, value);
  double opacity = tf_.opacities[o.index].opacity;
  if (o.t > 0) opacity = std::clamp(blend(opacity, tf_.opacities[o.index + 1].opacity, o.t), 0.0, 1.0);
  if (!(opacity > 0)) return {};
  const Place c = locate(tf_.colours, value);
  glm::dvec3 colour = linear_[c.index];
  if (c.t > 0) colour = blend(colour, linear_[c.index + 1], c.t);
  return {float(colour.x), float(colour.y), float(colour.z), float(corrected(opacity, length_))};
}

int Classifier::classify_row(const std::byte* row, int count, std::uint32_t* where,
                             ClassifiedSample* samples) const {
  return visit_type(type_, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (sizeof(T) <= 2) {
      return classify_by_table<std::make_unsigned_t<T>>(row, count, table_, visible_, where, samples);
    } else {
      const double low = support_low_, high = support_high_;
      const int candidates = select<T>(row, count, where, [low, high](T value) {
        return int(double(value) >= low) & int(double(value) <= high);
      });
      int visible = 0;
      for (int k = 0; k < candidates; ++k) {
        where[visible] = where[k];
        samples[visible] = evaluate(double(load<T>(row, int(where[visible]))));
        visible += samples[visible].opacity > 0;
      }
      return visible;
    }
  });
}

}  // namespace ringsplat

#include "sheet_engine/table_axis.hpp"

#include <algorithm>
#include <iterator>

#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

/// A part of an opacity curve where it changes.
struct Feature {
  double from, end, slope;  ///< the largest slope in it
  double width() const { return end - from; }
};

/// The parts of the curve within [low, high] that change by more than `most` a unit, ascending. Neighbours no
/// further apart than they are wide are one. Jumps are as narrow as an axis can resolve.
std::vector<Feature> features_of(const TransferFunction& tf, double low, double high, double most) {
  const double narrowest = (high - low) * TableAxis::narrowest;
  std::vector<Feature> features;
  for (std::size_t i = 0; i + 1 < tf.opacities.size(); ++i) {
    const auto &a = tf.opacities[i], &b = tf.opacities[i + 1];
    const double width = std::max(b.value - a.value, narrowest),
                 slope = std::abs(b.opacity - a.opacity) / width;
    const double before = b.value > a.value ? 0 : 0.5 * narrowest;
    const double from = std::clamp(a.value - before, low, high), end = std::clamp(a.value + width, low, high);
    if (!(slope > most && end > from)) continue;
    if (!features.empty() && from - features.back().end <= features.back().width() + (end - from))
      features.back() = {features.back().from, end, std::max(features.back().slope, slope)};
    else
      features.push_back({from, end, slope});
  }
  return features;
}

/// An even axis over what is not constant of a function, with half an entry beyond either end; over all
/// values where that is hardly less.
TableAxis::Ramp over_changes(const TransferFunction& tf, double low, double high) {
  double from = tf.opacities.front().value, end = tf.opacities.back().value;
  if (tf.opacities.front().opacity > 0) from = std::min(from, tf.colours.front().value);
  if (tf.opacities.back().opacity > 0) end = std::max(end, tf.colours.back().value);
  from = std::clamp(from, low, high);
  end = std::clamp(end, low, high);
  if (end - from > 0.5 * (high - low)) return {low, high - low, TableAxis::last / (high - low)};
  const double entry = (end - from) / (TableAxis::last - 1);
  return {from - 0.5 * entry, end - from + entry, 1 / entry};
}

}  // namespace

TableAxis::TableAxis(const TransferFunction& tf, double low, double high) {
  ramps[0] = {low, high - low, last / (high - low)};
  // The most that opacities may change from one entry to the next.
  constexpr double finely_enough = 0.125;
  auto features = features_of(tf, low, high, finely_enough * last / (high - low));
  // Slabs that only begin or end in a feature depend on how far from it their other end lies. So entries
  // become sparser with the distance.
  constexpr struct { double around, share; } rings[] = {{0, 0.5}, {2, 0.3}, {12, 0.2}};
  constexpr std::size_t most_features = (most_ramps - 1) / std::size(rings);
  coarse = features.size() > most_features;
  if (coarse) {
    features.clear();
    ramps[0] = over_changes(tf, low, high);
  }
  std::ranges::sort(features, [](const Feature& a, const Feature& b) { return a.slope > b.slope; });
  if (!features.empty()) ramps[0].rise *= 0.5;
  for (const Feature& feature : features)
    for (const auto& [around, share] : rings) {
      const double from = std::max(feature.from - around * feature.width(), low),
                   end = std::min(feature.end + around * feature.width(), high);
      ramps[std::size_t(count++)] = {from, end - from,
                                     0.5 * last * share / double(features.size()) / (end - from)};
    }
  for (int k = 0; k < count; ++k) {
    corners_.push_back(ramps[std::size_t(k)].from);
    corners_.push_back(ramps[std::size_t(k)].from + ramps[std::size_t(k)].width);
  }
  std::sort(corners_.begin(), corners_.end());
}

double TableAxis::place_of(double value) const {
  double place = 0;
  for (int k = 0; k < count; ++k) {
    const Ramp& ramp = ramps[std::size_t(k)];
    place += std::clamp(value - ramp.from, 0.0, ramp.width) * ramp.rise;
  }
  return place;
}

double TableAxis::value_at(double place) const {
  for (std::size_t k = 0; k + 1 < corners_.size(); ++k) {
    const double a = corners_[k], b = corners_[k + 1], at_a = place_of(a), at_b = place_of(b);
    if (place <= at_b || k + 2 == corners_.size())
      return at_b > at_a ? std::clamp(a + (b - a) * (place - at_a) / (at_b - at_a), a, b) : a;
  }
  return corners_.back();
}

PlaneCode PlaneCode::choose(ScalarType type, double low, double high, bool rounded, int pieces) {
  if (is_whole(type)) {
    // Extrapolations beyond the border, multiplied by up to `pieces`, and their differences fit 16 bits.
    const double most = std::min(4095, 8190 / pieces);
    if (high - std::floor(low) <= most) return {.offset = std::floor(low)};
    if (rounded) return {.offset = low, .scale = most / (high - low)};
  }
  const double largest = std::max(std::abs(low), std::abs(high));
  // Floats would have too few digits left for values that differ by so little of themselves.
  constexpr double alike = 1.0 / 64;
  const double offset = high - low < alike * largest ? low : 0, reach = offset != 0 ? high - low : largest;
  // Powers of two change no digit. Only doubles need them.
  const int exponent = reach > 1e30 || reach < 1e-30 ? std::ilogb(reach) : 0;
  return {.floats = true, .offset = offset, .scale = std::exp2(-double(exponent))};
}

}  // namespace ringsplat

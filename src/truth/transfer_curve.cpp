#include "truth/transfer_curve.hpp"

#include <algorithm>
#include <cmath>

namespace ringsplat::truth {
namespace {

/// IEC 61966-2-1:1999, section 5.2.
double linear_light(double display) {
  return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}

/// The piecewise-linear curve through `results` at ascending `values`, constant beyond the ends. Equal ends
/// are handled first, since (1 − t) a + t a may differ from a.
template <class T>
T on_line(const std::vector<double>& values, const std::vector<T>& results, double value) {
  const auto after = std::size_t(std::upper_bound(values.begin(), values.end(), value) - values.begin());
  if (after == 0) return results.front();
  if (after == values.size() || results[after - 1] == results[after]) return results[after - 1];
  // Halved, because the difference may overflow a double.
  const double t = (0.5 * value - 0.5 * values[after - 1]) / (0.5 * values[after] - 0.5 * values[after - 1]);
  return (1 - t) * results[after - 1] + t * results[after];
}

}  // namespace

TransferCurve::TransferCurve(const TransferFunction& tf) {
  for (const auto& p : tf.colours) {
    colour_values_.push_back(p.value);
    colours_.emplace_back(linear_light(p.srgb.x), linear_light(p.srgb.y), linear_light(p.srgb.z));
  }
  for (const auto& p : tf.opacities) {
    opacity_values_.push_back(p.value);
    opacities_.push_back(p.opacity);
  }
  knots_ = colour_values_;
  knots_.insert(knots_.end(), opacity_values_.begin(), opacity_values_.end());
  std::sort(knots_.begin(), knots_.end());
  knots_.erase(std::unique(knots_.begin(), knots_.end()), knots_.end());
}

TransferCurve::Sample TransferCurve::at(double value) const {
  if (std::isnan(value)) return {};
  return {on_line(colour_values_, colours_, value), on_line(opacity_values_, opacities_, value)};
}

bool TransferCurve::visible(double low, double high) const {
  if (!(low <= high)) return false;
  if (on_line(opacity_values_, opacities_, low) > 0 || on_line(opacity_values_, opacities_, high) > 0)
    return true;
  for (std::size_t i = 0; i < opacity_values_.size(); ++i)
    if (opacities_[i] > 0 && opacity_values_[i] >= low && opacity_values_[i] <= high) return true;
  return false;
}

double TransferCurve::bounded(double value) const {
  if (!std::isinf(value)) return value;
  const double margin = 1 + std::abs(value > 0 ? knots_.back() : knots_.front());
  return value > 0 ? knots_.back() + margin : knots_.front() - margin;
}

}  // namespace ringsplat::truth

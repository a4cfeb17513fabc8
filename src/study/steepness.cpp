#include "study/steepness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "classify/adjust.hpp"
#include "classify/piecewise.hpp"

namespace ringsplat::app {
namespace {

constexpr double share = 1.0 / 64;  ///< of the range: about what neighbouring voxels differ by
/// Between the gentle presets (mr-skin 0.02, mr-soft 0.02) and those of steep surfaces (ct-bone 0.06 and
/// more).
constexpr double steep = 0.04;

struct Measured {
  double value, rmse;  ///< steepness, and against the field in 1/255
};

/// Of the repository's head, with ramps (docs/measured/accuracy.md, "Steep transfer functions").
double expected_error(double steepness) {
  const std::vector<Measured> ramps{{0.044, 8.1}, {0.088, 9.1}, {0.176, 9.8}, {0.352, 10.7}, {0.703, 11.0}};
  const auto [k, t] = locate(ramps, steepness);
  return t > 0 ? std::lerp(ramps[k].rmse, ramps[k + 1].rmse, t) : ramps[k].rmse;
}

}  // namespace

double steepness(const TransferFunction& tf, const ValueRange& range) {
  if (!(range.low < range.high)) return 0;
  const DataRange values{range.low, range.high};
  const auto opacity = [&](double place) {
    return tf.evaluate(values.at(std::clamp(place, 0.0, 1.0))).opacity;
  };
  const double half_span = 0.5 * range.high - 0.5 * range.low;  // the span itself may overflow
  double most = 0;
  // Opacity is linear between points, so that the window of the largest change begins or ends at one, or has
  // a jump in it.
  for (const auto& point : tf.opacities) {
    const double at = (0.5 * point.value - 0.5 * range.low) / half_span;
    for (const double from : {at - share, at - 0.5 * share, at})
      most = std::max(most, std::abs(opacity(from + share) - opacity(from)));
  }
  return most;
}

std::string why_splats_err(const TransferFunction& tf, const ValueRange& range) {
  const double change = steepness(tf, range);
  if (change < steep) return {};
  return fmt::format(
      "transfer function '{}' is steep (its opacity changes by {:.2g} within 1/64 of the values' range), and "
      "splats are classified before they are interpolated: expect an error of about {:.0f}/255 rms, as rings "
      "and staircases; hint: --quality best interpolates first",
      tf.name, change, expected_error(change));
}

std::string why_sheets_err(const TransferFunction& tf, const ValueRange& range) {
  // One or two thin layers get nodes of their own.
  constexpr int nodes = 1020, resolved = 2;
  const double thin = (range.high / nodes) - (range.low / nodes);
  int layers = 0;
  for (std::size_t i = 1; i + 1 < tf.opacities.size(); ++i) {
    const auto &before = tf.opacities[i - 1], &peak = tf.opacities[i], &behind = tf.opacities[i + 1];
    if (peak.opacity > before.opacity && peak.opacity > behind.opacity && peak.value >= range.low &&
        peak.value <= range.high && behind.value - before.value < thin)
      ++layers;
  }
  if (layers <= resolved) return {};
  return fmt::format(
      "transfer function '{}' has {} layers thinner than 1/{} of the values' range, more than can be "
      "resolved: they are drawn wider and fainter; hint: make them wider, or leave only {}",
      tf.name, layers, nodes, resolved);
}

std::string why_labels_merge(const ValueRange& range) {
  constexpr double told_apart = 65535;
  if (!(range.high - range.low > told_apart)) return {};
  return fmt::format(
      "values run from {:.10g} to {:.10g}, of which sheets tell {:.0f} apart: neighbouring labels may have "
      "each "
      "other's colours; hint: --quality paper tells all apart",
      range.low, range.high, told_apart + 1);
}

}  // namespace ringsplat::app

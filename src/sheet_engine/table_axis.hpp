#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// Where values lie along an axis of the slab table, whose entries are at 0, 1 ... TableAxis::last: a rising,
/// piecewise linear function. Evenly over the volume's range where that resolves the opacities; otherwise
/// half of the entries are spent on the steepest parts of their curve and what lies near them. Where these
/// are too many, entries lie evenly over what is not constant, and values may lie beyond the ends.
struct TableAxis {
  static constexpr int entries = 256, last = entries - 1;
  static constexpr int most_ramps = 8;
  static constexpr double narrowest = 1e-6;  ///< feature that is told apart, of the range
  /// `rise` entries a unit, from `from` on over `width` units; ramps add up.
  struct Ramp {
    double from = 0, width = 1, rise = 1;
  };
  std::array<Ramp, most_ramps> ramps;
  int count = 1;
  bool coarse = false;  ///< too many parts are steep: entries do not resolve the opacities

  /// Over values `low` < `high`.
  TableAxis(const TransferFunction& transfer_function, double low, double high);
  bool even() const { return count == 1 && !coarse; }
  double place_of(double value) const;
  /// The smallest value at a place; the inverse of place_of().
  double value_at(double place) const;

 private:
  std::vector<double> corners_;  ///< values where the slope changes, ascending
};

/// How stored values become the numbers of a Renderer's planes: (value - offset) · scale, as whole numbers of
/// 16 bits or as floats.
struct PlaneCode {
  bool floats = false;
  bool labelled = false;  ///< beside each plane lies one of a segmentation's labels
  double offset = 0, scale = 1;
  /// What stands for infinite values: values beyond the transfer function's ends.
  double below = 0, above = 0;
  /// Values beyond are drawn as these: the table's ends, where outliers lie too far away to matter.
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  bool bounded() const { return std::isfinite(least) || std::isfinite(most); }
  double finite(double value) const {
    return std::clamp(!std::isinf(value) ? value : value > 0 ? above : below, least, most);
  }
  /// Whether a voxel's number is not its value's.
  bool rounds() const { return !floats && scale != 1; }
  double of(double value) const { return (finite(value) - offset) * scale; }
  bool operator==(const PlaneCode&) const = default;

  /// Whole numbers where they are exact, or, where they may be `rounded`, where a step is a sixteenth of an
  /// even axis' entry, an eighth with four pieces and a quarter with eight. Differences and sums of as many
  /// of them fit 16 bits. `pieces`: slabs a slice.
  static PlaneCode choose(ScalarType type, double low, double high, bool rounded, int pieces);
};

}  // namespace ringsplat

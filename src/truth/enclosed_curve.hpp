#pragma once
#include <array>
#include <vector>

#include "truth/interval.hpp"
#include "truth/scene.hpp"

namespace ringsplat::truth {

/// A transfer function as straight lines between its knots, with bounds of all rounding in it: red, green,
/// blue, opacity.
class EnclosedCurve {
 public:
  static constexpr std::size_t channels = 4, opacity = 3;
  using Channels = std::array<Interval, channels>;

  /// y + slope · (value − middle) in each channel.
  struct Line {
    double middle;
    Channels y, slope;
    Interval at(std::size_t channel, const Interval& value) const {
      const Interval& rise = slope[channel];
      return rise.lower() == 0 && rise.upper() == 0 ? y[channel] : y[channel] + rise * (value - middle);
    }
  };

  explicit EnclosedCurve(const TransferCurve& curve);

  /// The line on which a value is; at a knot the one above it.
  std::size_t line_of(double value) const;
  const Line& line(std::size_t k) const { return lines_[k]; }
  /// All that values in `value` have.
  Channels over(const Interval& value) const;
  /// How far values in `value` are from line k, at most.
  std::array<double, channels> off_line(std::size_t k, const Interval& value) const;

 private:
  /// Calls see(line, part of `value` on it) for all lines that values in it are on.
  template <class See>
  void for_lines(const Interval& value, const See& see) const;

  std::vector<double> knots_;
  std::vector<Line> lines_;  ///< one more than knots
};

}  // namespace ringsplat::truth

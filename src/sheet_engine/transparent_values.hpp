#pragma once
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// The values that a transfer function makes transparent, as intervals: those below and above all visible
/// values, and the widest gaps between. GPs leave out what lies in one interval, and Renderers add nothing
/// where all of a slab does; both must know the same intervals, or a picture's bits would depend on what was
/// left out.
class TransparentValues {
 public:
  static constexpr int most_gaps = 4;  ///< a Renderer asks about each at every pixel
  static constexpr int most = most_gaps + 2;
  static constexpr int nowhere = -1;

  struct Interval {
    double low, high;        ///< may be infinite
    bool has_low, has_high;  ///< whether the ends themselves are transparent
  };

  TransparentValues() = default;
  explicit TransparentValues(const TransferFunction& transfer_function);
  const std::vector<Interval>& intervals() const { return intervals_; }  ///< ascending, at most `most`
  /// The interval that holds all of [low, high], or nowhere.
  int holding(double low, double high) const;

 private:
  std::vector<Interval> intervals_;
};

}  // namespace ringsplat

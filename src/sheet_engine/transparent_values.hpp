#pragma once
#include <array>
#include <utility>
#include <vector>

#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// The values that leave a picture as it is, as intervals: of a transfer function those below and above all
/// visible values, and the widest gaps between. GPs leave out what lies in one interval, and Renderers add
/// nothing where all of a slab does; both must know the same intervals, or a picture's bits would depend on
/// what was left out.
class TransparentValues {
 public:
  static constexpr int most_gaps = 4;  ///< a Renderer asks about each at every pixel
  static constexpr int most = most_gaps + 2;
  static constexpr int nowhere = -1;

  struct Interval {
    double low, high;        ///< may be infinite
    bool has_low, has_high;  ///< whether the ends themselves are transparent
    bool operator==(const Interval&) const = default;
  };

  TransparentValues() = default;
  explicit TransparentValues(const TransferFunction& transfer_function);
  explicit TransparentValues(std::vector<Interval> intervals) : intervals_(std::move(intervals)) {}
  const std::vector<Interval>& intervals() const { return intervals_; }  ///< ascending, at most `most`
  /// The interval that holds all of [low, high], or nowhere.
  int holding(double low, double high) const;
  bool operator==(const TransparentValues&) const = default;

 private:
  std::vector<Interval> intervals_;
};

/// Of a picture in its mode: what is clear, too small an extremum (none, where it shows and holes may be), an
/// integral of nothing, or on one side of the surface.
TransparentValues transparent_values(const Shown& shown, ScalarType type);

/// What stands for the voxels of blocks that were left out: numbers that are as transparent as they are, by
/// the interval that holds them; the last one is not a number.
using Fillers = std::array<double, TransparentValues::most + 1>;
Fillers make_fillers(const TransparentValues& transparent, ScalarType type, double low, double high);

}  // namespace ringsplat

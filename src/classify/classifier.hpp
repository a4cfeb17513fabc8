#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// 64 neighbouring columns of a row, some of whose voxels are visible.
struct VisibleBlock {
  std::uint32_t first;   ///< column, a multiple of 64
  std::uint32_t sample;  ///< index, in the row's samples, of its first visible voxel
  std::uint64_t mask;    ///< bit i: column first + i is visible; never 0
};

/// The visible voxels (opacity above zero) of a row. Reuse it for row after row: its buffers only grow.
struct VisibleRow {
  std::vector<VisibleBlock> blocks;       ///< by ascending columns
  std::vector<ClassifiedSample> samples;  ///< of the visible voxels, once made: the first `visible` elements
  std::uint32_t visible = 0;
  /// Takes the voxels among columns first … end − 1 that are set in `masks`, a bit a column; makes no
  /// samples.
  void take(std::span<const std::uint64_t> masks, std::uint32_t first, std::uint32_t end);
};
/// Columns of a mask.
inline constexpr int mask_bits = 64;
/// Number of masks of a row.
constexpr std::size_t masks_of(int columns) { return (std::size_t(columns) + mask_bits - 1) / mask_bits; }

/// Turns rows of voxels into colour and opacity, for one transfer function and one view.
///
/// Opacity is corrected for the ray's distance from slice to slice: 1 − (1 − α)^length, `length` in unit
/// lengths (1 switches the correction off). 8- and 16-bit integers go through a table of the values that the
/// function spans; wider types are evaluated exactly. Not-a-number is transparent; an infinity takes the
/// colour and opacity of the last point on its side.
class Classifier {
 public:
  /// `tf`: checked.
  Classifier(const TransferFunction& tf, ScalarType type, double length);

  /// Sets the visible voxels' bits in the row's `masks`, a bit a column, for columns first … end − 1. `row`
  /// has scalars in native byte order, at any address. Several threads may call it.
  void find_row(const std::byte* row, int first, int end, std::uint64_t* masks) const;

  /// The samples of the values low … high. Values beyond have the sample of the nearer end.
  struct Table {
    const ClassifiedSample* samples;
    int low, high;
  };
  /// For 8- and 16-bit integers; empty for other types.
  std::optional<Table> table() const {
    if (table_.empty()) return {};
    return Table{table_.data(), table_low_, table_high_};
  }

  /// The sample of any value, for types without a table.
  ClassifiedSample evaluate(double value) const;

  ScalarType type() const { return type_; }

 private:
  template <class T>
  void make_table();
  std::size_t table_index(int value) const {
    return std::size_t(std::clamp(value, table_low_, table_high_) - table_low_);
  }

  TransferFunction tf_;
  ScalarType type_;
  double length_;
  std::vector<glm::dvec3> linear_;  ///< the colour points, in linear light
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  double support_low_ = infinity, support_high_ = -infinity;  ///< transparent outside; low > high: everywhere

  // For 8- and 16-bit types only:
  std::vector<ClassifiedSample> table_;  ///< of values table_low_ … table_high_; beyond, the ends hold
  int table_low_ = 0, table_high_ = 0;
};

}  // namespace ringsplat

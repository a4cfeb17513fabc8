#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "sheet_engine/table_axis.hpp"

namespace ringsplat {

/// The pre-integrated slab between two sheets (Engel, Kraus and Ertl 2001): for the values at its front and
/// back, between which the field is taken as linear, its opacity, its colour with what it hides of itself,
/// and where its opacity lies.
///
/// An entry has 64 bits: from the lowest on the root of its opacity (16), straight red, green and blue (10
/// each), centroid (8, of 255ths of the way from front to back), spread (6, of 127ths), steepness (4). The
/// root of opacity keeps the digits of faint slabs.
///
/// Steepness s: a change of the value half-way by an entry changes the opacity of two such slabs in turn by
/// at most 2^(s - 15), for values within `steep_reach` entries of the ends.
class SlabTable {
 public:
  static constexpr int steep_reach = 8;

  /// For values low < high, and slabs of `length` unit lengths. Does nothing when all is as before.
  void make(const TransferFunction& transfer_function, double low, double high, double length);

  /// The optical depth of a unit length times entries, from the axis' lowest value on: at share t of the way
  /// from a node to the next whole + rest + t (slope + t bend). `whole` has few digits, so that differences
  /// are exact.
  struct Depth {
    float whole, rest, slope, bend;
  };
  static constexpr int nodes_an_entry = 4;

  const TableAxis& axis() const { return *axis_; }
  /// By node, where the axis is coarse: from them opacities follow exactly, not by the nearest entry.
  const std::vector<Depth>& depths() const { return depths_; }
  /// [front * TableAxis::entries + back].
  const std::uint64_t* entries() const { return entries_.data(); }

  /// The transfer function integrated over value, by quarters of entries; what a length does not change.
  struct Curve {
    static constexpr int nodes = TableAxis::last * nodes_an_entry + 1;
    std::vector<double> value;             ///< by node
    std::vector<double> extinction;        ///< integral up to each node
    std::vector<double> red, green, blue;  ///< integrals of extinction times straight colour
    std::vector<double> at_entry;          ///< extinction of each entry's value
    std::vector<glm::dvec3> colour;        ///< at each entry, straight
  };

 private:
  TransferFunction transfer_function_;
  double low_ = 0, high_ = 0, length_ = 0;
  std::optional<TableAxis> axis_;
  Curve curve_;
  std::vector<Depth> depths_;
  std::vector<std::uint64_t> entries_;
};

/// The slabs of one value each, where a slab has its nearest voxel's: entries as in SlabTable, at even steps
/// from the volume's lowest value on. Whole numbers have an entry each where the range allows it.
class ValueTable {
 public:
  static constexpr double most_steps = 65535,
                          fine_steps = 4095;  ///< `fine_steps`: of values between whole numbers

  /// As SlabTable::make().
  void make(const TransferFunction& transfer_function, double low, double high, bool whole_numbers,
            double length);

  double low() const { return low_; }
  double steps_a_unit() const { return steps_a_unit_; }
  int last() const { return int(samples_.size()) - 1; }
  const std::uint64_t* entries() const { return entries_.data(); }

 private:
  struct Sample {
    double extinction;
    glm::dvec3 colour;
  };
  TransferFunction transfer_function_;
  double low_ = 0, high_ = 0, length_ = 0, steps_a_unit_ = 1;
  bool whole_numbers_ = false;
  std::vector<Sample> samples_;  ///< by entry; what a length does not change
  std::vector<std::uint64_t> entries_;
};

}  // namespace ringsplat

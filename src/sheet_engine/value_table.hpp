#pragma once
#include <cstdint>
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// The slabs of one value each, where a slab has its nearest voxel's: entries as in SlabTable, at even steps
/// from the volume's lowest value on. Whole numbers have an entry each where the range allows it.
class ValueTable {
 public:
  static constexpr double most_steps = 65535,
                          fine_steps = 4095;  ///< `fine_steps`: of values between whole numbers

  /// For values low < high. Does nothing when all is as before.
  void set_function(const TransferFunction& transfer_function, double low, double high, bool whole_numbers);
  /// For slabs of `length` unit lengths. Call set_function() first.
  void set_length(double length);

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

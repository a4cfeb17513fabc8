#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// Turns rows of voxels into colour and opacity, for one transfer function and one view.
///
/// The opacity handed out is corrected for the distance the ray runs from slice to slice: 1 − (1 − α)^length,
/// `length` in unit lengths (1 switches the correction off). 8- and 16-bit integers go through a table of all
/// their values; wider types are evaluated exactly. Not-a-number is transparent; an infinity lies beyond the
/// last point of its side and takes that point's colour and opacity.
class Classifier {
 public:
  /// Throws InputError for a transfer function that check() refuses and a length that is not positive.
  Classifier(const TransferFunction& tf, ScalarType type, double length);

  /// The visible voxels (opacity above zero) of a row of `count` scalars in native byte order, any alignment:
  /// their positions, ascending, into `where`, their samples into `samples` (room for `count` each). Returns
  /// how many there are. Safe to call from several threads.
  int classify_row(const std::byte* row, int count, std::uint32_t* where, ClassifiedSample* samples) const;

  ScalarType type() const { return type_; }

 private:
  ClassifiedSample evaluate(double value) const;

  TransferFunction tf_;
  ScalarType type_;
  double length_;
  std::vector<glm::dvec3> linear_;       ///< the colour points in linear light
  double support_low_, support_high_;    ///< transparent outside; low > high when everything is
  std::vector<ClassifiedSample> table_;  ///< by the value's bit pattern, 8- and 16-bit types only
  std::vector<std::uint8_t> visible_;    ///< 1 where the table's opacity is above zero
};

}  // namespace ringsplat

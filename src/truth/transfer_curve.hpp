#pragma once
#include <glm/vec3.hpp>
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat::truth {

/// A transfer function evaluated straight from its points.
class TransferCurve {
 public:
  explicit TransferCurve(const TransferFunction& tf);

  struct Sample {
    glm::dvec3 colour{0.0};  ///< straight, linear
    double opacity = 0;      ///< per unit length
  };
  /// Not-a-number is transparent; of points with equal values the last holds at the value itself.
  Sample at(double value) const;
  /// True when some value in [low, high] has opacity above zero; may be true for a jump at an end.
  bool visible(double low, double high) const;
  /// Values at which a line of colour or opacity bends or jumps, ascending, each once.
  const std::vector<double>& knots() const { return knots_; }
  /// Infinities become finite values beyond the function's ends, which can be interpolated.
  double bounded(double value) const;

 private:
  std::vector<double> colour_values_, opacity_values_, opacities_, knots_;
  std::vector<glm::dvec3> colours_;
};

}  // namespace ringsplat::truth

#pragma once
#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

inline TransferFunction two_points(double low, double opacity_low, double high, double opacity_high) {
  TransferFunction tf;
  tf.colours = {{low, {0.2, 0.4, 0.6}}, {high, {1, 0.5, 0}}};
  tf.opacities = {{low, opacity_low}, {high, opacity_high}};
  return tf;
}

}  // namespace ringsplat

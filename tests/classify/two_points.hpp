#pragma once
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

inline TransferFunction two_points(double low, double opacity_low, double high, double opacity_high) {
  TransferFunction tf;
  tf.colours = {{low, {0.2, 0.4, 0.6}}, {high, {1, 0.5, 0}}};
  tf.opacities = {{low, opacity_low}, {high, opacity_high}};
  return tf;
}

template <class T>
ScalarType type_of() {
  for (const auto type : {ScalarType::int8, ScalarType::uint8, ScalarType::int16, ScalarType::uint16,
                          ScalarType::int32, ScalarType::uint32, ScalarType::float32})
    if (visit_type(type, [](auto v) { return std::is_same_v<decltype(v), T>; })) return type;
  return ScalarType::float64;
}

}  // namespace ringsplat

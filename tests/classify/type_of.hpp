#pragma once
#include <type_traits>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

template <class T>
ScalarType type_of() {
  for (const auto type : {ScalarType::int8, ScalarType::uint8, ScalarType::int16, ScalarType::uint16,
                          ScalarType::int32, ScalarType::uint32, ScalarType::float32})
    if (visit_type(type, [](auto v) { return std::is_same_v<decltype(v), T>; })) return type;
  return ScalarType::float64;
}

}  // namespace ringsplat

#pragma once

namespace ringsplat::detail {

/// Values of ElementType, in ScalarType's order.
inline constexpr const char* meta_types[] = {"MET_CHAR", "MET_UCHAR", "MET_SHORT", "MET_USHORT",
                                             "MET_INT",  "MET_UINT",  "MET_FLOAT", "MET_DOUBLE"};

}  // namespace ringsplat::detail
